"""The grid's word on what is optimal."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from study.simulated.rollouts import States
from study.tasks.navigation import IDLE, Parameters, spread_states
from study.training.grid_model import GridModel
from study.training.value_iteration import evaluate, solve


class Idle:
    """Does nothing."""

    def actions(self, states: States, random: np.random.Generator) -> npt.NDArray[np.int32]:
        """Return idle for each state."""
        return np.full(len(states), IDLE, np.int32)


@pytest.fixture(scope="module")
def model() -> GridModel:
    return GridModel(Parameters.model_validate({}), cell=0.6, headings=24, levels=11)


def test_shares_add_up(model: GridModel) -> None:
    """Every state is shared wholly among nodes."""
    states = spread_states({}, np.random.default_rng(1), 500)
    _, shares = model.grid.share(states)
    assert np.allclose(shares.sum(axis=1), 1)
    assert np.allclose(model.grid.level_shares(states[:, 3].astype(np.float64)).sum(axis=1), 1)


def test_doing_nothing_is_worth_its_timesteps(model: GridModel) -> None:
    """Away from hazards and packs an idle robot loses a timestep's points for ever."""
    values = evaluate(model, Idle(), np.random.default_rng(0), tolerance=1e-4)
    (found,) = values.values(np.array([[5.0, 1.0, 0.0, 80.0]], np.float32))
    assert found == pytest.approx(-0.05 / (1 - 0.99), abs=0.02)


def test_solution_is_a_fixed_point_and_beats_doing_nothing(model: GridModel) -> None:
    """Another sweep changes little, and the optimum is nowhere worse than a policy."""
    solved = solve(model, tolerance=0.01)
    q = model.rewards() + 0.99 * model.ahead(solved.nodes)
    soft = q.max(axis=0) + 0.05 * np.log(np.exp((q - q.max(axis=0)) / 0.05).sum(axis=0))
    assert np.abs(soft - solved.nodes)[:, 1:].max() < 0.01
    idle = evaluate(model, Idle(), np.random.default_rng(0))
    assert (solved.nodes[:, 1:] >= idle.nodes[:, 1:] - 1.0).all()
