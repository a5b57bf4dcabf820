"""The parts of a session read as one recording, whatever broke it off."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from event_books import check_books
from fake_shell import FakeShell, Moods
from short_study import opened, short_study
from study.commands.recover import salvaged_path
from study.commands.resuming import find_end, restore
from study.events.events import Deviation, StageEntered, TrialEnded, TrialStarted
from study.events.fields import Record
from study.events.inputs import FocusChanged, Input, QuitRequested, SessionResumed
from study.events.shell import ClockPair
from study.recording.client import Recorder
from study.recording.losses import Loss
from study.recording.parts import (
    SessionRecording,
    base_name,
    join_parts,
    part_files,
    part_name,
    part_number,
    read_session,
    read_sessions,
)
from study.recording.reader import RawRecord
from study.recording.salvage import salvage
from study.recording.wire import decode, encode
from study.session.session import Session
from study.verification import verify_recording


class MemoryPart:
    """Stands in for one file: its records in order."""

    def __init__(self, rows: list[RawRecord], part: int, *, session_id: str = "s") -> None:
        self.rows = rows
        self.path = Path(f"x_part{part}.mcap")
        self.metadata = {"part": str(part)}
        self.session_id = session_id
        self.problems: tuple[str, ...] = ()
        self.losses: tuple[Loss, ...] = ()
        self.complete = True
        self.unclosed = False

    def raw(self, *families: str) -> Iterator[RawRecord]:
        """Yield the records of some families."""
        for row in self.rows:
            if not families or row.topic.split("/")[0] in families:
                yield row

    def records(self, *topics: str) -> Iterator[tuple[int, Record]]:
        """Yield the records of some topics."""
        for row in self.rows:
            if row.topic in topics:
                yield row.sequence, decode(row.topic, row.data)


def joined(*parts: MemoryPart) -> SessionRecording:
    """Join parts to one session."""
    made: Any = parts
    (session,) = join_parts(made)
    return session


def written(records: list[Record], first: int) -> list[RawRecord]:
    """Number and encode records."""
    return [
        RawRecord(first + place, record.topic, 1_000 + record.t_ns, encode(record))
        for place, record in enumerate(records)
    ]


def recorded(inputs: list[Input], session: Session | None = None) -> list[Record]:
    """Return inputs with the events that follow from each, as a conductor records them."""
    session = session or Session()
    found: list[Record] = []
    for given_input in inputs:
        found += [given_input, *session.handle(given_input).events]
    return found


def live(shell: FakeShell, count: int, chance: random.Random) -> None:
    """Let a participant do something, with pauses, lost focus and keys pressed at random."""
    for _ in range(count):
        if shell.finished:
            return
        what = chance.random()
        if what < 0.05:
            shell.key("escape")
        elif what < 0.08:
            shell.feed(FocusChanged(shell.later(), chance.random() < 0.5))
        elif what < 0.2:
            shell.tap(chance.choice(["1", "2", "up", "left", "tab", "q"]))
        else:
            shell.help()


def entered_once(events: list[Any]) -> list[Any]:
    """Leave out what a resume enters again, and the fit and the reveal that it repeats."""
    found: list[Any] = []
    again = False
    for event in events:
        again = again or (isinstance(event, Deviation) and event.code == "resumed")
        if again and isinstance(event, StageEntered):
            again = False
        else:
            found.append(event)
    return found


moods = st.builds(
    Moods,
    fits=st.lists(
        st.sampled_from(["completed", "completed", "failed", "timed out"]), min_size=1
    ).map(tuple),
)


@settings(max_examples=30, phases=[Phase.explicit, Phase.generate])
@given(
    seed=st.integers(0, 2**32 - 1),
    moods=moods,
    lives=st.lists(st.tuples(st.integers(0, 250), st.floats(0, 1)), min_size=1, max_size=3),
    ends_early=st.booleans(),
)
def test_any_cuts_replay_across_parts(
    seed: int, moods: Moods, lives: list[tuple[int, float]], ends_early: bool
) -> None:
    """However often and wherever a session breaks off, it replays, and each trial counts once."""
    chance = random.Random(seed)
    shell = FakeShell(opened(short_study(), seed=seed), seed % 1000, moods)
    beginning = Session()
    parts: list[MemoryPart] = []
    number = 1
    for count, where in lives:
        live(shell, count, chance)
        if ends_early and not shell.finished:
            shell.feed(QuitRequested(shell.later(), "SIGTERM"))
        rows = written(recorded(shell.inputs, beginning), number)
        shortest = 0 if parts else 3
        parts.append(
            MemoryPart(rows[: shortest + round(where * (len(rows) - shortest))], len(parts) + 1)
        )
        session = joined(*parts)
        if any(getattr(e, "complete", False) for _, e in session.records("event/session_ended")):
            return
        boundary, end = restore(session), find_end(session)
        number = end.sequence + 1
        first = end.resumed(boundary.after_sequence, end.t_ns + 1, end.log_time_ns)
        shell.session, beginning = boundary.session, restore(session).session
        shell.inputs, shell.fleet, shell.pace = [], None, 0.0
        shell.fits.clear()
        shell.finished, shell.t_ns = False, first.t_ns
        shell.feed(first)
    shell.go_on_until(lambda: shell.finished)
    parts.append(MemoryPart(written(recorded(shell.inputs, beginning), number), len(parts) + 1))
    session = joined(*parts)
    assert session.complete, session.faults
    verdict = verify_recording(session)
    assert verdict.matches, verdict.difference
    events: list[Any] = [decode(raw.topic, raw.data) for raw in session.raw("event")]
    check_books(entered_once(events), short_study().description.idle_action, lawful=True)
    times = [decode(raw.topic, raw.data).t_ns for raw in session.raw()]
    assert times == sorted(times)
    places = [
        (e.phase, e.block, e.condition, e.trial) for e in events if isinstance(e, TrialStarted)
    ]
    ends = [e for e in events if isinstance(e, TrialEnded)]
    assert all(e.complete for e in ends)
    assert len(ends) == len(places) == len(set(places))
    stages = [e.stage for e in events if isinstance(e, StageEntered)]
    resumed = [e for e in events if isinstance(e, Deviation) and e.code == "resumed"]
    assert set(stages) == set(range(max(stages) + 1))
    assert len(stages) == len(set(stages)) + len(resumed)
    assert {e.part for _, e in session.records(SessionResumed.topic)} >= {len(parts)}  # type: ignore[attr-defined]


# Parts that repeat one another: what a failed writer leaves


def clock(number: int) -> ClockPair:
    """Return a record that carries its number."""
    return ClockPair(t_ns=number, utc_ns=number)


def rows(first: int, last: int) -> list[RawRecord]:
    """Return numbered records, both ends included; the opening note before them."""
    note = RawRecord(0, ClockPair.topic, 0, encode(clock(first)))
    return [note, *written([clock(number) for number in range(first, last + 1)], first)]


@given(
    cuts=st.lists(st.tuples(st.integers(1, 40), st.integers(0, 20)), min_size=1, max_size=4),
    order=st.randoms(use_true_random=False),
)
def test_repeated_records_count_once(cuts: list[tuple[int, int]], order: random.Random) -> None:
    """Records sent again to a later part are taken from the first that has them, in order."""
    parts = []
    last = 0
    for place, (more, repeated) in enumerate(cuts, start=1):
        first = max(1, last + 1 - repeated)
        last += more
        parts.append(MemoryPart(rows(first, last), place))
    order.shuffle(parts)
    session = joined(*parts)
    assert [raw.sequence for raw in session.raw()] == list(range(last + 1))
    assert session.complete
    assert session.problems == ()
    assert session.left_out_records == session.left_out_trials == 0


def test_gap_between_parts_is_a_problem() -> None:
    """Records in none of the parts are named, and the session is not complete."""
    session = joined(MemoryPart(rows(1, 10), 1), MemoryPart(rows(15, 20), 2))
    assert session.problems == ("Records 11 to 14 are in none of the parts found.",)
    assert not session.complete
    assert session.losses == (Loss(11, 14, None, None),)
    alone = joined(MemoryPart(rows(15, 20), 2))
    assert alone.problems == ("Records 1 to 14 are in none of the parts found.",)


def test_torn_part_that_another_makes_up_for_is_no_problem() -> None:
    """What a torn file lacks is no loss if the next part holds it; other damage is told."""
    torn = MemoryPart(rows(1, 10), 1)
    torn.complete, torn.unclosed, torn.problems = False, True, ("The end is missing.",)
    session = joined(torn, MemoryPart(rows(9, 20), 2))
    assert session.complete
    assert session.problems == ()
    assert session.remarks == (
        "Part 1 was not closed; part 2 goes on from record 11: nothing is missing.",
    )
    assert not joined(torn).complete
    assert joined(torn).problems == ("The end is missing.",)
    damaged = MemoryPart(rows(1, 10), 1)
    damaged.problems = ("The attachment is missing.",)
    told = joined(damaged, MemoryPart(rows(9, 20), 2))
    assert (told.problems, told.remarks) == (("Part 1: The attachment is missing.",), ())


def test_torn_part_that_nothing_makes_up_for_is_a_problem() -> None:
    """Where records are missing all is told that is wrong; so it is of the last part."""
    torn = MemoryPart(rows(1, 10), 1)
    torn.complete, torn.unclosed, torn.problems = False, True, ("The end is missing.",)
    session = joined(torn, MemoryPart(rows(15, 20), 2))
    assert session.problems == (
        "Part 1: The end is missing.",
        "Records 11 to 14 are in none of the parts found.",
    )
    assert session.remarks == ()
    last = MemoryPart(rows(11, 20), 2)
    last.complete, last.unclosed, last.problems = False, True, ("The end is missing.",)
    session = joined(MemoryPart(rows(1, 10), 1), last)
    assert (session.problems, session.remarks) == (("Part 2: The end is missing.",), ())


def test_a_part_that_holds_nothing_new_is_passed_over() -> None:
    """A writer that failed at once is not the one that the session goes on with."""
    first, second = MemoryPart(rows(1, 10), 1), MemoryPart(rows(9, 10), 2)
    for torn in (first, second):
        torn.complete, torn.unclosed, torn.problems = False, True, ("The end is missing.",)
    session = joined(first, second, MemoryPart(rows(9, 20), 3))
    assert session.remarks == tuple(
        f"Part {part} was not closed; part 3 goes on from record 11: nothing is missing."
        for part in (1, 2)
    )


def test_contradicting_repetition_is_a_problem() -> None:
    """A record that differs from its first copy is reported; the first counts."""
    other = rows(8, 12)
    other[2] = dataclasses.replace(other[2], data=encode(clock(99)))
    session = joined(MemoryPart(rows(1, 10), 1), MemoryPart(other, 2))
    assert session.problems == ("Record 9 of x_part2.mcap differs in a part before it.",)
    assert next(r for n, r in session.records(ClockPair.topic) if n == 9).t_ns == 9
    assert not session.complete


def test_copies_and_other_sessions_stay_apart() -> None:
    """A second file of a part, and files of other sessions, are sessions of their own."""
    parts: Any = [
        MemoryPart(rows(1, 5), 1),
        MemoryPart(rows(1, 5), 1),
        MemoryPart(rows(1, 5), 1, session_id="t"),
        MemoryPart(rows(6, 7), 2),
        MemoryPart(rows(1, 5), 1, session_id=""),
        MemoryPart(rows(1, 5), 1, session_id=""),
    ]
    assert [len(session.parts) for session in join_parts(parts)] == [2, 1, 1, 1, 1]


# Files


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two parts of a session and a session beside them, on disk."""
    for name, part, session, first in [
        ("one", 1, "a", 1),
        ("one_part2", 2, "a", 11),
        ("one_more", 1, "b", 1),
    ]:
        recorder = Recorder.start(
            tmp_path,
            name,
            {},
            {"session_id": session, "part": str(part)},
            first_sequence=first,
        )
        for number in range(first, first + 10):
            recorder.write(clock(number), number)
        recorder.close()
    return tmp_path


@pytest.mark.parametrize("name", ["one.mcap", "one_part2.mcap"])
def test_any_part_leads_to_its_session(folder: Path, name: str) -> None:
    """The parts beside a file are found by name and session; arrays span them."""
    session = read_session(folder / name)
    assert [part.path.name for part in session.parts] == ["one.mcap", "one_part2.mcap"]
    assert [part_number(part) for part in session.parts] == [1, 2]
    assert session.path.name == "one.mcap"
    assert session.session_id == "a"
    assert len(session.sha256) == 64
    runs = session.columns(ClockPair.topic)
    assert np.concatenate([run["t_ns"] for run in runs]).tolist() == list(range(1, 21))


def test_sessions_of_a_folder_are_joined(folder: Path) -> None:
    """Each session comes once, in the order of its first file; one part is its own recording."""
    sessions = read_sessions(sorted(folder.glob("*.mcap")))
    assert [(s.session_id, len(s.parts)) for s in sessions] == [("a", 2), ("b", 1)]
    alone = sessions[1]
    assert alone.sha256 == alone.parts[0].sha256
    assert alone.metadata == alone.parts[0].metadata
    assert list(alone.raw()) == list(alone.parts[0].raw())


def test_unfinished_parts_are_found_too(folder: Path) -> None:
    """A part may still end in .part; a file that has both names is taken once."""
    (folder / "one_part2.mcap").rename(folder / "one_part2.mcap.part")
    (folder / "one_part10.mcap").touch()
    (folder / "one.mcap.part").touch()
    names = [path.name for path in part_files(folder / "one_part2.mcap.part")]
    assert names == ["one.mcap", "one_part2.mcap.part", "one_part10.mcap"]
    assert part_files(folder / "notes.txt") == [folder / "notes.txt"]


def test_salvaged_copies_stand_for_parts_that_are_not_there(folder: Path) -> None:
    """Beside its original a copy is taken only where it is given itself."""
    for name in ("one", "one_part2"):
        salvage(folder / f"{name}.mcap", salvaged_path(folder / f"{name}.mcap"))

    def parts(name: str) -> list[str]:
        return [part.path.name for part in read_session(folder / name).parts]

    assert parts("one.mcap") == ["one.mcap", "one_part2.mcap"]
    assert parts("one_part2_salvaged.mcap") == ["one.mcap", "one_part2_salvaged.mcap"]
    (folder / "one.mcap").unlink()
    assert parts("one_part2.mcap") == ["one_salvaged.mcap", "one_part2.mcap"]
    assert not read_session(folder / "one_part2.mcap").without_first


def test_names_of_parts() -> None:
    """Part 1 has the recording's name, later ones their number; the way back is the same."""
    for part in (1, 2, 12):
        for suffix in (".mcap", ".mcap.part", "_salvaged.mcap"):
            assert base_name(Path(part_name("x_P01", part) + suffix)) == "x_P01"
