"""What validation says of a protocol's length."""

from __future__ import annotations

import pytest

from study.durations import dwell_seconds, expected_minutes
from study.loading import load_protocol


def test_dwell_in_seconds() -> None:
    """Fifteen timesteps at eight a second; the manual condition has no dwell."""
    ((condition, seconds),) = dwell_seconds(load_protocol("scaled_autonomy").protocol)
    assert condition.name == "assisted"
    assert seconds == pytest.approx(15 / 8)


@pytest.mark.parametrize(
    ("name", "least", "most"), [("scaled_autonomy", 20, 60), ("pilot", 7, 13), ("smoke", 1, 6)]
)
def test_expected_minutes(name: str, least: float, most: float) -> None:
    """The pilot takes about ten minutes; every stage takes part of the time."""
    loaded = load_protocol(name)
    stages = dict(expected_minutes(loaded.protocol, loaded.description.horizon))
    assert all(minutes > 0 for minutes in stages.values())
    assert least < sum(stages.values()) < most
    assert [stage for stage in stages if stage.startswith("Phase three")] == [
        "Phase three, manual",
        "Phase three, assisted",
    ]


def test_longer_trials_take_longer() -> None:
    """A study's minutes follow from its trials."""
    loaded = load_protocol("smoke")
    three = loaded.protocol.phase_three.model_copy(update={"trials": 11})
    longer = loaded.protocol.model_copy(update={"phase_three": three})
    before = sum(minutes for _, minutes in expected_minutes(loaded.protocol, 20))
    after = sum(minutes for _, minutes in expected_minutes(longer, 20))
    # Ten more trials of 4 s and 4 s of readiness in each of two conditions.
    assert (after - before) * 60 == pytest.approx(2 * 10 * (4 + 4))
