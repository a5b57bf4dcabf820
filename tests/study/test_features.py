"""The encoding of states as features."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.events.task_description import StateField
from study.features import encode, feature_names, standardisation

FIELDS = (
    StateField("x", "m", 0.0, 20.0),
    StateField("heading", "rad", -math.pi, math.pi, circular=True),
)
DEGREES = (StateField("heading", "degree", 0.0, 360.0, circular=True),)


def test_sine_and_cosine_stand_for_angles() -> None:
    """An angle becomes two features on a circle; the others are scaled by their range."""
    states = np.array([[5.0, math.pi / 2]], np.float32)
    assert encode(states, FIELDS)[0] == pytest.approx([0.25, 1 / (2 * math.pi), 0.0], abs=1e-6)
    assert feature_names(FIELDS) == ("x", "sin heading", "cos heading")


def test_small_turns_count_as_their_part_of_the_range() -> None:
    """A hundredth of a turn is as far as a hundredth of any other field's range."""
    turned = np.array([[5.0, 1.0], [5.0, 1.0 + 2 * math.pi / 100]], np.float32)
    moved = np.array([[5.0, 1.0], [5.2, 1.0]], np.float32)
    ways = [np.linalg.norm(np.diff(encode(states, FIELDS), axis=0)) for states in (turned, moved)]
    assert ways[0] == pytest.approx(ways[1], rel=1e-3)


@given(st.floats(0, 360, width=32), st.integers(-3, 3))
def test_whole_turns_change_nothing(angle: float, turns: int) -> None:
    """An angle in any unit gives the same features after whole turns."""
    states = np.array([[angle], [angle + 360.0 * turns]], np.float32)
    here, there = encode(states, DEGREES)
    assert here == pytest.approx(there, abs=1e-4)


def test_scaled_and_raw() -> None:
    """Encoding "scaled" maps the range to 0 to 1, "raw" leaves the numbers alone."""
    states = np.array([[20.0, 0.0]], np.float32)
    assert encode(states, FIELDS, "scaled")[0] == pytest.approx([1.0, 0.5])
    assert encode(states, FIELDS, "raw")[0] == pytest.approx([20.0, 0.0])


def test_standardised_features_have_mean_0_and_deviation_1() -> None:
    """Standardisation centres and scales what is not an angle."""
    states = np.random.default_rng(0).uniform(0, 3, (500, 2)).astype(np.float32)
    features = encode(states, FIELDS, standard=standardisation(states, FIELDS))
    assert features[:, 0].mean() == pytest.approx(0, abs=1e-9)
    assert features[:, 0].std() == pytest.approx(1, abs=1e-9)
    assert (features[:, 1] ** 2 + features[:, 2] ** 2) == pytest.approx(np.ones(500))


def test_a_field_that_does_not_vary_is_harmless() -> None:
    """A constant field is encoded as 0, not divided by zero."""
    states = np.full((10, 2), 0.1, np.float32)
    features = encode(states, FIELDS, standard=standardisation(states, FIELDS))
    assert features[:, 0] == pytest.approx(np.zeros(10), abs=1e-9)
