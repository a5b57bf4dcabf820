"""The rehearsal task is as unrepeatable as it claims, within its declared ranges."""

from __future__ import annotations

import numpy as np

from study.events.codes import Outcome
from study.tasks import erratic

QUICK = {"slowest_ms": 0.0}


def test_equal_seeds_do_not_repeat() -> None:
    """Two runs from the same seeds and actions differ."""
    every, seeds = np.ones(3, np.bool_), np.arange(3, dtype=np.uint64)
    starts = [erratic.create(3, QUICK).reset(every, seeds) for _ in range(2)]
    assert starts[0].tobytes() != starts[1].tobytes()


def test_episodes_end_now_and_then() -> None:
    """With a high chance of ending all robots end, in more than one way."""
    task = erratic.create(200, QUICK | {"end_chance": 0.5})
    every = np.ones(200, np.bool_)
    task.reset(every, np.zeros(200, np.uint64))
    for _ in range(40):
        outcomes = task.step(np.zeros(200, np.int32), every).outcomes
    assert set(outcomes.tolist()) == {Outcome.GOAL, Outcome.LOST}


def test_the_horizon_holds() -> None:
    """An episode that nothing else ends ends at the horizon."""
    task = erratic.create(2, QUICK | {"end_chance": 0.0, "horizon": 2})
    every = np.ones(2, np.bool_)
    task.reset(every, np.zeros(2, np.uint64))
    first = task.step(np.zeros(2, np.int32), every).outcomes
    second = task.step(np.zeros(2, np.int32), every).outcomes
    assert first.tolist() == [Outcome.RUNNING] * 2
    assert second.tolist() == [Outcome.TIME_UP] * 2
