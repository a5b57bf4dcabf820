"""The synthetic user that ships: what it does, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy

from study.errors import StudyError
from study.events.codes import Outcome
from study.perceptron import read_weights
from study.simulated.rollouts import roll_out
from study.simulated.trained_user import WEIGHTS, TrainedUser
from study.simulated.values import lambda_returns
from study.tasks import navigation

PARAMETERS = navigation.Parameters.model_validate({}).model_dump(mode="json")
SHIPPED = WEIGHTS / "navigation.safetensors"


def _states(count: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    return navigation.spread_states({}, np.random.default_rng(1), count)


def test_chances_add_up_and_values_are_finite() -> None:
    """Each state has a distribution over the five actions, and a value."""
    user = TrainedUser.shipped("navigation", PARAMETERS)
    chances = user.probabilities(_states(100))
    assert chances.shape == (100, 5)
    assert np.allclose(chances.sum(axis=1), 1)
    assert np.isfinite(user.values(_states(100))).all()


def test_actions_are_drawn_by_their_chances() -> None:
    """Drawn many times in one state, actions come as often as they should."""
    user = TrainedUser.shipped("navigation")
    state = np.repeat(_states(1), 20_000, axis=0)
    shares = np.bincount(user.actions(state, np.random.default_rng(2)), minlength=5) / 20_000
    assert np.abs(shares - user.probabilities(state[:1])[0]).max() < 0.02


def test_it_drives_to_the_goal_and_returns_are_monte_carlo() -> None:
    """At least 95 % reach the goal; lambda-returns at 1 are what was earned."""
    user = TrainedUser.shipped("navigation")
    task = navigation.create(60, {})
    run = roll_out(task, user, np.arange(60, dtype=np.uint64), np.random.default_rng(3))
    assert (run.outcomes == Outcome.GOAL).mean() >= 0.95
    earned = np.where(run.running, run.returns(0.99), 0.0)
    ended = np.isin(run.outcomes, (Outcome.GOAL, Outcome.LOST))
    found = lambda_returns(run, 0.99, 1.0, user)
    assert np.allclose(found[:, ended], earned[:, ended])


def test_other_parameters_are_refused_by_name_and_the_horizon_may_differ() -> None:
    """The message names the parameter that differs."""
    TrainedUser.shipped("navigation", {**PARAMETERS, "horizon": 500})
    with pytest.raises(StudyError, match=r"forward is 0\.4, trained for 0\.5"):
        TrainedUser.shipped("navigation", {**PARAMETERS, "forward": 0.4})
    with pytest.raises(StudyError, match="no trained user"):
        TrainedUser.shipped("erratic")


@pytest.mark.parametrize("damage", ["cut", "empty", "huge", "not finite", "no metadata", "shape"])
def test_damaged_weights_are_refused_in_words(damage: str, tmp_path: Path) -> None:
    """No damage gives anything but a message."""
    path = tmp_path / "user.safetensors"
    tensors, metadata = read_weights(SHIPPED)
    if damage == "cut":
        path.write_bytes(SHIPPED.read_bytes()[:500])
    elif damage == "empty":
        path.write_bytes(b"")
    elif damage == "huge":
        path.write_bytes(bytes(5_000_000))
    else:
        if damage == "not finite":
            tensors["actor.layer0.weight"][0, 0] = np.nan
        if damage == "shape":
            tensors["actor.layer1.weight"] = tensors["actor.layer1.weight"][:, :-1].copy()
        kept = {} if damage == "no metadata" else {"user": metadata["user"]}
        safetensors.numpy.save_file(tensors, path, kept)
    with pytest.raises(StudyError):
        TrainedUser.load(path, "navigation")


def test_weights_say_what_made_them() -> None:
    """Command, seed and versions are in the file."""
    made_of = json.loads(read_weights(SHIPPED)[1]["user"])
    assert made_of["command"].startswith("study train-user scaled_autonomy --seed 1")
    assert {"python", "numpy", "torch"} <= set(made_of["versions"])
