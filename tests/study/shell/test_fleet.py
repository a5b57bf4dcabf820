"""The fleet, inline or in a process of its own: same task, same answers."""

from __future__ import annotations

import os
import signal
from operator import attrgetter
from typing import Any

import numpy as np
import pytest

from study.errors import StudyError
from study.policies.nearest_neighbor import fit
from study.session.effects import StartFleet, StepFleet
from study.shell.fleet import Fleet, InlineFleet, ProcessFleet, open_fleet
from study.shell.fleet_host import FleetAnswer

ROBOTS = 3


def start(**changes: Any) -> StartFleet:
    """Return a request to start three robots."""
    values: dict[str, Any] = {
        "request_id": 1,
        "trial_id": 0,
        "robots": ROBOTS,
        "seeds": np.arange(10, 10 + ROBOTS, dtype=np.uint64),
        "policy_id": "uniform_random",
        "policy_seed": 4,
        "scorer_id": "",
    }
    return StartFleet(**{**values, **changes})


def step(request_id: int, *, reset: int = -1) -> StepFleet:
    """Return a request to drive ahead; ``reset`` is started anew instead."""
    resets = np.arange(ROBOTS) == reset
    return StepFleet(
        request_id=request_id,
        actions=np.zeros(ROBOTS, np.int32),
        active=~resets,
        reset=resets,
        seeds=np.where(resets, 77, 0).astype(np.uint64),
    )


def ask(fleet: Fleet, effect: StartFleet | StepFleet) -> FleetAnswer:
    """Ask and wait for the answer."""
    fleet.request(effect)
    for _ in range(100):
        answer = fleet.poll(0.5)
        if isinstance(answer, FleetAnswer):
            return answer
    raise AssertionError("no answer")


def fingerprint(answer: FleetAnswer) -> tuple[Any, ...]:
    """Return an answer's numbers and bytes."""
    names = ("states", "rewards", "outcomes", "policy_actions", "scores")
    return (answer.request_id, *(getattr(answer, name).tobytes() for name in names))


def run(fleet: Fleet) -> list[tuple[Any, ...]]:
    """Start, step, learn a policy, start with it."""
    answers = [ask(fleet, start()), ask(fleet, step(2)), ask(fleet, step(3, reset=1))]
    arrays = {
        "states": answers[0].states,
        "actions": np.arange(ROBOTS, dtype=np.int32),
    }
    from study.tasks.navigation import describe

    weights = fit(arrays, describe({}), {}, 0).weights
    fleet.add_artefact("policy:x", "policy", "nearest_neighbor", weights)
    answers.append(ask(fleet, start(request_id=4, policy_id="policy:x")))
    assert answers[-1].policy_actions.tolist() == [0, 1, 2]
    return [fingerprint(answer) for answer in answers]


def test_process_and_inline_fleets_answer_alike() -> None:
    """Where the task runs changes nothing in what it answers, byte for byte."""
    inline, process = InlineFleet("navigation", {}), ProcessFleet("navigation", {})
    try:
        assert run(inline) == run(process)
    finally:
        inline.close()
        process.close()


def test_answers_have_the_declared_types_and_a_start_has_no_rewards() -> None:
    """What goes into a recording has the types that are declared."""
    fleet = open_fleet("navigation", {})
    assert isinstance(fleet, InlineFleet)
    answer = ask(fleet, start())
    assert answer.states.shape == (ROBOTS, 4)
    types: tuple[Any, ...] = (
        answer.states.dtype,
        answer.rewards.dtype,
        answer.outcomes.dtype,
        answer.scores.dtype,
    )
    assert types == (np.float32, np.float32, np.int32, np.float64)
    assert not answer.rewards.any()
    assert not answer.outcomes.any()
    assert answer.scores.size == 0
    assert fleet.poll() is None
    fleet.close()


def test_robot_started_anew_has_its_seed_s_state_and_no_reward() -> None:
    """A reset in a step gives the state that its seed gives at a start."""
    fleet = InlineFleet("navigation", {})
    ask(fleet, start())
    answer = ask(fleet, step(2, reset=1))
    again = ask(fleet, start(seeds=np.full(ROBOTS, 77, np.uint64)))
    assert np.array_equal(answer.states[1], again.states[1])
    assert answer.rewards[1] == 0
    assert answer.outcomes[1] == 0


def test_slow_task_gets_a_process_and_its_death_is_said() -> None:
    """A task that asks for it runs apart; when it dies the study hears so."""
    fleet = open_fleet("erratic", {"slowest_ms": 0.0})
    try:
        assert isinstance(fleet, ProcessFleet)
        assert ask(fleet, start()).request_id == 1
        os.kill(attrgetter("_worker._process.pid")(fleet), signal.SIGKILL)
        with pytest.raises(StudyError, match="ended unexpectedly"):
            fleet.poll(5.0)
    finally:
        fleet.close()


def test_failing_fleet_says_why() -> None:
    """A request that the process cannot serve ends the session with the reason."""
    fleet = ProcessFleet("navigation", {})
    try:
        with pytest.raises(StudyError, match='unknown policy "policy:none"'):
            ask(fleet, start(policy_id="policy:none"))
    finally:
        fleet.close()
