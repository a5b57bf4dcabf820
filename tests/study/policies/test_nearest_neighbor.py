"""1-nearest-neighbour equals brute force, ties included."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.features import Encoding, encode
from study.policies import nearest_neighbor
from study.policies.nearest_neighbor import NearestNeighbor
from study.tasks import navigation

DESCRIPTION = navigation.describe({})
RANDOM = np.random.default_rng(0)
ENCODINGS: list[Encoding] = ["sine_cosine", "scaled", "raw"]


def _fitted(
    states: npt.NDArray[np.float32], actions: npt.NDArray[np.int32], encoding: Encoding
) -> NearestNeighbor:
    arrays = {"states": states, "actions": actions}
    fitted = nearest_neighbor.fit(arrays, DESCRIPTION, {"encoding": encoding}, 0)
    return nearest_neighbor.load(fitted.weights, DESCRIPTION)


def _brute_force(
    states: npt.NDArray[np.float32],
    actions: npt.NDArray[np.int32],
    queries: npt.NDArray[np.float32],
    description: TaskDescription,
    encoding: Encoding,
) -> list[int]:
    """Of the nearest demonstrations the most recent, by comparing with all of them."""
    known = encode(states, description.state_fields, encoding)
    answers = []
    for query in encode(queries, description.state_fields, encoding):
        squared = ((known - query) ** 2).sum(axis=1)
        answers.append(int(actions[np.flatnonzero(squared == squared.min())[-1]]))
    return answers


@settings(max_examples=150)
@given(st.integers(1, 60), st.integers(0, 2**32), st.integers(1, 4), st.sampled_from(ENCODINGS))
def test_equals_brute_force_with_ties(
    count: int, seed: int, largest: int, encoding: Encoding
) -> None:
    """On whole numbers, where ties abound, every action is brute force's."""
    random = np.random.default_rng(seed)
    states = random.integers(0, largest + 1, (count, 4)).astype(np.float32)
    actions = np.arange(count, dtype=np.int32)  # tells the demonstrations apart
    queries = (random.integers(0, 2 * largest + 1, (30, 4)) / 2).astype(np.float32)
    policy = _fitted(states, actions, encoding)
    expected = _brute_force(states, actions, queries, DESCRIPTION, encoding)
    assert policy.actions(queries, RANDOM).tolist() == expected


@settings(max_examples=30)
@given(st.integers(0, 2**32), st.sampled_from(ENCODINGS))
def test_equals_brute_force_on_real_states(seed: int, encoding: Encoding) -> None:
    """On states of the task every action is brute force's."""
    random = np.random.default_rng(seed)
    low, high = (0, 0, -3.14, 0), (20, 15, 3.14, 100)
    states = random.uniform(low, high, (300, 4)).astype(np.float32)
    queries = random.uniform(low, high, (50, 4)).astype(np.float32)
    actions = random.integers(0, 4, 300).astype(np.int32)
    expected = _brute_force(states, actions, queries, DESCRIPTION, encoding)
    assert _fitted(states, actions, encoding).actions(queries, RANDOM).tolist() == expected


def test_a_correction_overrules_what_it_corrects() -> None:
    """Of demonstrations in one state the most recent is kept, the others are dropped."""
    states = np.tile(np.array([[1.0, 1.0, 0.0, 50.0]], np.float32), (3, 1))
    arrays = {"states": states, "actions": np.array([3, 1, 2], np.int32)}
    fitted = nearest_neighbor.fit(arrays, DESCRIPTION, {}, 0)
    policy = nearest_neighbor.load(fitted.weights, DESCRIPTION)
    assert policy.actions(states[:1], RANDOM).tolist() == [2]
    assert fitted.metrics == {"demonstrations": 3, "kept": 1}


def test_headings_wrap_around() -> None:
    """Just below pi is next to just above -pi when angles are sine and cosine."""
    states = np.array([[1, 1, 3.1, 50], [1, 1, 0.0, 50]], np.float32)
    query = np.array([[1, 1, -3.1, 50]], np.float32)
    actions = np.array([0, 1], np.int32)
    assert _fitted(states, actions, "sine_cosine").actions(query, RANDOM).tolist() == [0]
    assert _fitted(states, actions, "raw").actions(query, RANDOM).tolist() == [1]


def test_no_demonstrations_is_said_in_words() -> None:
    """An empty training set is the user's to mend."""
    arrays = {"states": np.zeros((0, 4), np.float32), "actions": np.zeros(0, np.int32)}
    with pytest.raises(StudyError, match="no demonstrations"):
        nearest_neighbor.fit(arrays, DESCRIPTION, {}, 0)


def test_numbers_that_are_not_finite_are_refused() -> None:
    """A distance to nowhere is no distance."""
    arrays = {"states": np.full((1, 4), np.nan, np.float32), "actions": np.zeros(1, np.int32)}
    with pytest.raises(StudyError, match="not finite"):
        nearest_neighbor.fit(arrays, DESCRIPTION, {}, 0)
