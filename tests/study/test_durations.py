"""What validation says of a protocol's length."""

from __future__ import annotations

import pytest

from study.durations import (
    CONSENT_S,
    PAGE_S,
    QUESTION_S,
    SURVEY_S,
    dwell_seconds,
    expected_minutes,
)
from study.loading import load_protocol
from study.seat_settings import BreakPart


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


@pytest.mark.parametrize(
    ("part", "stage", "seconds"),
    [
        ("consent", "Welcome and practice", CONSENT_S),
        ("comprehension", "Welcome and practice", QUESTION_S),
        ("debrief", "Questions and debrief", PAGE_S),
    ],
)
def test_every_part_of_a_session_takes_time(part: str, stage: str, seconds: float) -> None:
    """What a protocol has beside trials is counted, and only where it has it."""
    loaded = load_protocol("every_screen")
    without = loaded.protocol.model_copy(update={part: None})
    before, after = (dict(expected_minutes(p, 20)) for p in (without, loaded.protocol))
    assert (after[stage] - before[stage]) * 60 == pytest.approx(seconds)


def test_breaks_are_before_blocks_and_within_them() -> None:
    """Each at its suggested length; none after a block's last trial."""
    protocol = load_protocol("smoke").protocol
    three = protocol.phase_three.model_copy(update={"trials": 5})
    breaks = BreakPart(seconds=20, minimum_seconds=5, every_trials=2)
    longer = protocol.model_copy(update={"phase_three": three})
    found = [
        sum(minutes for _, minutes in expected_minutes(each, 20))
        for each in (longer, longer.model_copy(update={"breaks": breaks}))
    ]
    # Two blocks, each with one before it, after its second trial and after its fourth.
    assert (found[1] - found[0]) * 60 == pytest.approx(2 * 3 * 20)


def test_questionnaires_are_counted_when_they_are_asked() -> None:
    """Those of the start and the end once, those around a reveal in each block."""
    protocol = load_protocol("smoke").protocol
    (use,) = protocol.questionnaires

    def minutes(*when: str) -> dict[str, float]:
        asked = (use.model_copy(update={"when": when}),)
        return dict(expected_minutes(protocol.model_copy(update={"questionnaires": asked}), 20))

    none = minutes()
    for occasion, stages in {
        "at_start": {"Welcome and practice"},
        "at_end": {"Questions and debrief"},
        "before_reveal": {"Phase three, manual", "Phase three, assisted"},
    }.items():
        found = minutes(occasion)
        longer = {name for name in found if found[name] > none.get(name, 0.0)}
        assert longer == stages, occasion
        assert sum(found.values()) - sum(none.values()) == pytest.approx(
            len(stages) * SURVEY_S / 60
        )


def test_longer_trials_take_longer() -> None:
    """A study's minutes follow from its trials."""
    loaded = load_protocol("smoke")
    three = loaded.protocol.phase_three.model_copy(update={"trials": 11})
    longer = loaded.protocol.model_copy(update={"phase_three": three})
    before = sum(minutes for _, minutes in expected_minutes(loaded.protocol, 20))
    after = sum(minutes for _, minutes in expected_minutes(longer, 20))
    # Ten more trials of 4 s and 4 s of readiness in each of two conditions.
    assert (after - before) * 60 == pytest.approx(2 * 10 * (4 + 4))
