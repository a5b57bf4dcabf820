"""What the user's networks see of a state and of the map."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Any

import numpy as np
import pytest

from study.simulated.landmarks import MAX_LANDMARKS, Landmarks
from study.tasks import navigation

DESCRIPTION = navigation.describe({})
LANDMARKS = Landmarks.of(DESCRIPTION)


def test_features_are_as_many_as_said_and_bounded() -> None:
    """Whatever the state, no feature is large: networks learn from numbers of like size."""
    states = navigation.spread_states({}, np.random.default_rng(1), 2000)
    features = LANDMARKS.features(states)
    assert features.shape == (2000, LANDMARKS.size)
    assert np.abs(features).max() <= 1 + 1e-6


def test_a_heading_that_comes_round_changes_nothing() -> None:
    """Half a turn to the left is half a turn to the right."""
    states = navigation.spread_states({}, np.random.default_rng(2), 50)
    left, right = states.copy(), states.copy()
    left[:, 2], right[:, 2] = math.pi - 1e-6, -math.pi + 1e-6
    assert np.allclose(LANDMARKS.features(left), LANDMARKS.features(right), atol=1e-4)


def test_neighbouring_places_and_headings_differ() -> None:
    """Half a metre and a turn of 15 degrees both move the features by far more than rounding."""
    state = np.array([[9.0, 2.0, 0.3, 80.0]], np.float32)
    before = LANDMARKS.features(state)
    for change in ([0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, math.radians(15), 0], [0, 0, 0, 10]):
        assert (
            np.abs(LANDMARKS.features(state + np.array(change, np.float32)) - before).max() > 0.05
        )


def test_a_disc_ahead_is_told_from_one_aside() -> None:
    """Facing a disc its bearing has sine 0 and cosine 1; with it on the left, sine 1."""
    one = dataclasses.replace(
        LANDMARKS, discs=np.array([[5.0, 5.0, 0.5]]), hazards=np.empty((0, 4))
    )
    facing, aside = np.array([[2.0, 5.0, 0.0, 80.0], [2.0, 5.0, -math.pi / 2, 80.0]], np.float32)
    circled = (one.size - 1 - len(one.fields) - 1) // 2
    sines = slice(len(one.fields) + 1, len(one.fields) + 1 + circled)
    found = one.features(np.stack([facing, aside]))[:, sines][:, -1]
    assert found == pytest.approx([0.0, 1.0], abs=1e-6)


def test_json_gives_the_same_features() -> None:
    """What the weights' file holds of the map is all that is needed."""
    states = navigation.spread_states({}, np.random.default_rng(3), 20)
    again = Landmarks.from_json(json.loads(json.dumps(LANDMARKS.to_json())))
    assert np.array_equal(again.features(states), LANDMARKS.features(states))
    assert again.size == LANDMARKS.size


def test_a_task_without_a_map_has_its_plain_state() -> None:
    """Fields alone, circular ones as sine and cosine."""
    flat = Landmarks.of(dataclasses.replace(DESCRIPTION, x_field=-1, y_field=-1))
    states = navigation.spread_states({}, np.random.default_rng(4), 5)
    assert flat.features(states).shape == (5, 5) == (5, flat.size)


@pytest.mark.parametrize(
    "change",
    [
        {"fields": []},
        {"place": [0]},
        {"place": [0, 9]},
        {"heading": 9},
        {"heading": "north"},
        {"discs": [[1.0, 2.0]]},
        {"discs": [[1.0, 2.0, math.inf]]},
        {"hazards": [[0.0, 0.0, 1.0, 1.0]] * (MAX_LANDMARKS + 1)},
        {"fields": [{"name": "x", "unit": "m", "low": 0.0, "high": 0.0}] * 2},
    ],
    ids=str,
)
def test_what_is_no_map_is_refused(change: dict[str, Any]) -> None:
    """Weights' metadata come from a file that anybody may have written."""
    with pytest.raises((KeyError, TypeError, ValueError)):
        Landmarks.from_json({**LANDMARKS.to_json(), **change})
