"""The heuristic scorers put first whom their names say."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from study.errors import StudyError
from study.scorers import lowest_health, novelty
from study.tasks import navigation

DESCRIPTION = navigation.describe({})
STATES = np.array([[2, 2, 0, 80], [8, 2, 0, 20], [2, 2.5, 0, 60]], np.float32)


def test_least_health_comes_first() -> None:
    """Only health counts, wherever the robot is."""
    fitted = lowest_health.fit({}, DESCRIPTION, {}, 0)
    scores = lowest_health.load(fitted.weights, DESCRIPTION).scores(STATES)
    assert scores.argsort().tolist() == [0, 2, 1]


def test_a_task_without_health_is_refused() -> None:
    """There is nothing to score by, which is said before anything runs."""
    without = dataclasses.replace(DESCRIPTION, health_field=-1)
    with pytest.raises(StudyError, match="no health"):
        lowest_health.fit({}, without, {}, 0)


def test_the_strangest_state_comes_first() -> None:
    """Known are the states of the robots operated, not of those that were passed over."""
    arrays = {
        "states": STATES[None, [0, 1]],
        "chosen": np.zeros(1, np.int32),
    }
    scorer = novelty.load(novelty.fit(arrays, DESCRIPTION, {}, 0).weights, DESCRIPTION)
    scores = scorer.scores(STATES)
    assert scores[0] == 0.0
    assert scores.argsort().tolist() == [0, 2, 1]


def test_novelty_is_the_same_across_the_turn_of_the_circle() -> None:
    """Headings just below and just above half a turn are neighbours."""
    known = np.array([[[2, 2, 3.14, 80]]], np.float32)
    arrays = {"states": known, "chosen": np.zeros(1, np.int32)}
    scorer = novelty.load(novelty.fit(arrays, DESCRIPTION, {}, 0).weights, DESCRIPTION)
    near, far = scorer.scores(np.array([[2, 2, -3.14, 80], [2, 2, 0, 80]], np.float32))
    assert near < 0.01 < far


def test_novelty_needs_a_state_to_know() -> None:
    """Without any choice it says what to do."""
    empty = {"states": np.zeros((0, 4, 4), np.float32), "chosen": np.zeros(0, np.int32)}
    with pytest.raises(StudyError, match="no states"):
        novelty.fit(empty, DESCRIPTION, {}, 0)
