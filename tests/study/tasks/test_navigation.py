"""The navigation task: independence of robots, legal states, outcomes and points."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from study.events.codes import Outcome
from study.tasks import navigation
from study.tasks.base import SnapshotTask
from study.tasks.navigation import BACKWARD, FORWARD, IDLE, TURN_LEFT, TURN_RIGHT, NavigationTask

EVERY = np.ones(1, np.bool_)
runs = st.tuples(st.integers(1, 6), st.integers(0, 2**63), st.integers(1, 60))


def _fleet(seeds: npt.NDArray[np.uint64], **parameters: object) -> NavigationTask:
    task = navigation.create(len(seeds), parameters)
    task.reset(np.ones(len(seeds), np.bool_), seeds)
    return task


def _placed(state: list[float], **parameters: object) -> NavigationTask:
    """One robot without noise, put into a state."""
    task = _fleet(np.array([1], np.uint64), noise=0.0, **parameters)
    memory: dict[str, npt.NDArray[Any]] = task.snapshot()
    memory["states"][0] = state
    x, y = memory["states"][:, 0].astype(np.float64), memory["states"][:, 1].astype(np.float64)
    memory["distances"] = task.terrain.goal_distance(x, y)
    task.restore(memory)
    return task


def _driven(task: NavigationTask, *actions: int) -> tuple[npt.NDArray[np.float32], float, int]:
    """Drive one robot; return its state, the sum of its rewards and its outcome."""
    total = 0.0
    for action in actions:
        step = task.step(np.array([action], np.int32), EVERY)
        total += float(step.rewards[0])
    return step.states[0], total, int(step.outcomes[0])


@settings(max_examples=40)
@given(runs)
def test_a_fleet_steps_as_its_robots_would_alone(run: tuple[int, int, int]) -> None:
    """States, rewards and outcomes do not depend on how many robots there are."""
    robots, seed, length = run
    random = np.random.default_rng(seed)
    seeds = random.integers(0, 2**63, robots).astype(np.uint64)
    actions = random.integers(0, 5, (length, robots)).astype(np.int32)
    active = random.random((length, robots)) < 0.8
    fleet = _fleet(seeds, horizon=40)
    alone = [_fleet(seeds[i : i + 1], horizon=40) for i in range(robots)]
    for row, mask in zip(actions, active, strict=True):
        together = fleet.step(row, mask)
        for i, task in enumerate(alone):
            step = task.step(row[i : i + 1], mask[i : i + 1])
            assert step.states[0].tobytes() == together.states[i].tobytes()
            assert step.rewards[0] == together.rewards[i]
            assert step.outcomes[0] == together.outcomes[i]


@settings(max_examples=40)
@given(runs, st.sampled_from([[0.9, 0.0, 0.05, 0.05, 0.0], [0.4, 0.2, 0.2, 0.1, 0.1]]))
def test_states_stay_legal(run: tuple[int, int, int], chances: list[float]) -> None:
    """No robot leaves the floor, the range of its heading or that of its health."""
    robots, seed, length = run
    random = np.random.default_rng(seed)
    task = _fleet(random.integers(0, 2**63, robots).astype(np.uint64))
    for _ in range(length):
        actions = random.choice(5, robots, p=chances).astype(np.int32)
        step = task.step(actions, np.ones(robots, np.bool_))
        x, y, heading, health = step.states.astype(np.float64).T
        assert task.terrain.is_legal(x, y).all()
        assert ((heading >= -math.pi) & (heading < math.pi)).all()
        assert ((health >= 0) & (health <= 100)).all()
        assert np.isfinite(step.rewards).all()


@settings(max_examples=30)
@given(runs)
def test_a_snapshot_repeats_the_future(run: tuple[int, int, int]) -> None:
    """Restored into another task, a snapshot leads to the same states and rewards."""
    robots, seed, length = run
    random = np.random.default_rng(seed)
    task = _fleet(random.integers(0, 2**63, robots).astype(np.uint64))
    every = np.ones(robots, np.bool_)
    actions = random.integers(0, 5, (length, robots)).astype(np.int32)
    for row in actions:
        task.step(row, every)
    snapshot = task.snapshot()
    first = [task.step(row, every) for row in actions]
    other = navigation.create(robots, {})
    other.restore(snapshot)
    for row, was in zip(actions, first, strict=True):
        again = other.step(row, every)
        assert again.states.tobytes() == was.states.tobytes()
        assert again.rewards.tobytes() == was.rewards.tobytes()
        assert again.outcomes.tobytes() == was.outcomes.tobytes()


def test_ended_robots_are_untouched() -> None:
    """A robot whose time is up neither moves nor earns, even if it is called active."""
    task = _fleet(np.array([1, 2], np.uint64), horizon=3)
    every = np.ones(2, np.bool_)
    for _ in range(3):
        last = task.step(np.zeros(2, np.int32), every)
    assert last.outcomes.tolist() == [Outcome.TIME_UP] * 2
    after = task.step(np.zeros(2, np.int32), every)
    assert after.states.tobytes() == last.states.tobytes()
    assert after.rewards.tolist() == [0, 0]


def test_starts_are_free_and_spread() -> None:
    """Start states lie in the first room, outside the hazard, with healths in range."""
    task = _fleet(np.arange(400, dtype=np.uint64))
    x, y, heading, health = task.snapshot()["states"].astype(np.float64).T
    assert (task.terrain.is_legal(x, y) & ~task.terrain.in_hazard(x, y)).all()
    assert ((x < 9.4) & (y < 7.0)).all()
    assert ((health >= 60) & (health <= 100)).all()
    assert x.std() > 2
    assert y.std() > 1
    assert heading.std() > 1.5


def test_equal_seeds_start_equally_and_others_do_not() -> None:
    """The seed alone decides the start and the noise."""
    memory = _fleet(np.array([7, 7, 8], np.uint64)).snapshot()
    assert memory["states"][0].tobytes() == memory["states"][1].tobytes()
    assert memory["noise"][0].tobytes() == memory["noise"][1].tobytes()
    assert memory["states"][0].tobytes() != memory["states"][2].tobytes()


@pytest.mark.parametrize(
    ("action", "expected"),
    [
        (FORWARD, [2.5, 1.0, 0.0, 80.0]),
        (BACKWARD, [1.7, 1.0, 0.0, 80.0]),
        (TURN_LEFT, [2.0, 1.0, math.radians(15), 80.0]),
        (TURN_RIGHT, [2.0, 1.0, -math.radians(15), 80.0]),
        (IDLE, [2.0, 1.0, 0.0, 80.0]),
    ],
)
def test_actions_move_as_named(action: int, expected: list[float]) -> None:
    """Without noise each action has exactly its declared effect."""
    state, _, _ = _driven(_placed([2.0, 1.0, 0.0, 80.0]), action)
    assert state == pytest.approx(expected, abs=1e-6)


def test_robots_slide_along_walls() -> None:
    """A robot that heads into a wall at a slant keeps the part of its way along it."""
    state, _, _ = _driven(_placed([5.0, 0.4, -math.pi / 4, 80.0]), FORWARD)
    assert state[:2] == pytest.approx([5.0 + 0.5 * math.cos(math.pi / 4), 0.4], abs=1e-6)


def test_walls_stop_and_doors_let_pass() -> None:
    """Straight to the east the wall stops a robot; through the door it reaches the next room."""
    stopped, _, _ = _driven(_placed([8.5, 1.0, 0.0, 80.0]), *[FORWARD] * 6)
    passed, _, _ = _driven(_placed([8.5, 5.0, 0.0, 80.0]), *[FORWARD] * 6)
    assert stopped[0] <= 9.05
    assert passed[0] == pytest.approx(11.5)


def test_progress_is_paid_by_the_metre() -> None:
    """Straight towards the goal a robot earns its way less the timesteps."""
    task = _placed([18.0, 9.0, math.pi, 80.0])
    start = math.hypot(18.0 - 11.3, 9.0 - 12.7)
    _, total, _ = _driven(task, FORWARD, FORWARD)
    end = math.hypot(17.0 - 11.3, 9.0 - 12.7)
    assert total == pytest.approx(start - end - 0.1, abs=1e-5)


def test_hazards_hurt_and_packs_heal() -> None:
    """Health changes each timestep and is paid; it never exceeds 100."""
    hurt, paid, _ = _driven(_placed([5.0, 3.0, 0.0, 80.0]), IDLE, IDLE)
    assert hurt[3] == 70
    assert paid == pytest.approx(-1.0 - 0.1)
    healed, paid, _ = _driven(_placed([1.6, 5.4, 0.0, 85.0]), IDLE, IDLE)
    assert healed[3] == 100
    assert paid == pytest.approx(1.5 - 0.1)


def test_health_zero_loses_the_robot() -> None:
    """The last point lost ends the episode and costs the penalty."""
    state, paid, outcome = _driven(_placed([5.0, 3.0, 0.0, 4.0]), IDLE)
    assert (state[3], outcome) == (0, Outcome.LOST)
    assert paid == pytest.approx(-0.4 - 10 - 0.05)


def test_reaching_the_goal_pays() -> None:
    """Within the goal's radius the episode ends well."""
    _, paid, outcome = _driven(_placed([11.3, 11.3, math.pi / 2, 80.0]), FORWARD)
    assert outcome == Outcome.GOAL
    assert paid == pytest.approx(0.5 + 10 - 0.05, abs=1e-5)


@pytest.mark.parametrize("action", [-1, 5])
def test_unknown_actions_are_refused(action: int) -> None:
    """A number that names no action is an error, not another action."""
    with pytest.raises(ValueError, match="actions must be 0 to 4"):
        _fleet(np.array([1], np.uint64)).step(np.array([action], np.int32), EVERY)


@pytest.mark.parametrize(
    "parameters",
    [{"forward": 0.7}, {"start_health": (90, 60)}, {"speed": 1.0}, {"rewards": {"gold": 1.0}}],
)
def test_impossible_parameters_are_refused(parameters: dict[str, object]) -> None:
    """Steps that jump a wall, empty ranges and unknown names are no parameters."""
    with pytest.raises(ValidationError):
        navigation.describe(parameters)


def test_rewards_reach_the_instructions() -> None:
    """What a protocol sets is what the points rules say."""
    description = navigation.describe({"rewards": {"goal": 25.0}})
    assert {term.name: term.value for term in description.rewards}["goal"] == 25.0
    assert isinstance(navigation.create(1, {}), SnapshotTask)
