"""Verification notices whatever does not follow, and says where."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from fake_shell import FakeShell
from short_study import opened, short_study
from study.events.events import SessionEnded, Timestep
from study.recording.reader import RawRecord
from study.recording.wire import decode, encode
from study.session.session import Session
from study.verification import Verdict, verify_recording


class Records:
    """Stands in for a recording: its records in order."""

    def __init__(self, rows: list[tuple[str, bytes]], *, complete: bool = True) -> None:
        self.rows = rows
        self.complete = complete
        self.losses: tuple[()] = ()

    def raw(self, *families: str) -> list[RawRecord]:
        """Return the records."""
        return [RawRecord(place, topic, 0, data) for place, (topic, data) in enumerate(self.rows)]


@pytest.fixture(scope="module")
def rows() -> list[tuple[str, bytes]]:
    """The inputs and events of a session, in the order they are recorded."""
    shell = FakeShell(opened(short_study()))
    shell.go_on_until(lambda: shell.finished)
    session = Session()
    found: list[tuple[str, bytes]] = []
    for given in shell.inputs:
        found.append((given.topic, encode(given)))
        found += [(event.topic, encode(event)) for event in session.handle(given).events]
    return found


def check(rows: list[tuple[str, bytes]], *, complete: bool = True) -> Verdict:
    """Verify records."""
    recording: Any = Records(rows, complete=complete)
    return verify_recording(recording)


def place_of(rows: list[tuple[str, bytes]], topic: str, number: int = 0) -> int:
    """Return the place of the n-th record of a topic."""
    return [place for place, row in enumerate(rows) if row[0] == topic][number]


def test_whole_session_matches(rows: list[tuple[str, bytes]]) -> None:
    """Every input is replayed and every event compared."""
    verdict = check(rows)
    assert verdict.matches, verdict.difference
    assert verdict.inputs + verdict.events == len(rows)


def test_every_field_of_a_timestep_is_compared(rows: list[tuple[str, bytes]]) -> None:
    """A change of any number or array is found, and named."""
    place = place_of(rows, Timestep.topic, 3)
    row: Any = decode(*rows[place])
    for field in dataclasses.fields(row):
        value = getattr(row, field.name)
        if field.name == "robots" or not getattr(value, "size", 1):
            continue
        forged = dataclasses.replace(row, **{field.name: value + 1})
        verdict = check([*rows[:place], (Timestep.topic, encode(forged)), *rows[place + 1 :]])
        assert not verdict.matches
        assert verdict.difference == f"record {place}: event/timestep differs in {field.name}"


@pytest.mark.parametrize("number", [0, 5])
def test_missing_and_added_events_are_found(rows: list[tuple[str, bytes]], number: int) -> None:
    """An event that was taken out, or put in, is a difference."""
    place = place_of(rows, Timestep.topic, number)
    without = check([*rows[:place], *rows[place + 1 :]])
    assert not without.matches
    twice = check([*rows[: place + 1], *rows[place:]])
    assert not twice.matches
    assert f"record {place + 1}:" in twice.difference


def test_missing_input_is_found(rows: list[tuple[str, bytes]]) -> None:
    """Without an input its events follow from nothing."""
    place = place_of(rows, Timestep.topic) - 1
    assert rows[place][0] == "input/fleet_observed"
    verdict = check([*rows[:place], *rows[place + 1 :]])
    assert verdict.difference == f"record {place}: event/timestep follows from no input"


def test_torn_end_is_no_difference_but_a_missing_one_is(rows: list[tuple[str, bytes]]) -> None:
    """A torn file may lack its last events; a finished one may not."""
    cut = rows[: place_of(rows, SessionEnded.topic)]
    assert check(cut, complete=False).matches
    verdict = check(cut)
    assert verdict.difference == "event/session_ended is missing at the end"


def test_nothing_proves_nothing() -> None:
    """A recording without inputs is not called identical."""
    assert not check([]).matches
