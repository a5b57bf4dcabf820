"""A tape shows what the session showed, from anywhere, and no more than was recorded."""

from __future__ import annotations

import dataclasses
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cut_sessions import resume, seen_session, study_loaded, write_part
from study.commands.resuming import find_boundary
from study.errors import RecordingError
from study.events.events import Timestep
from study.events.inputs import FleetObserved, SessionOpened
from study.recording.parts import SessionRecording, read_whole_session
from study.recording.reader import RawRecord
from study.recording.wire import decode, encode
from study.screens import FleetScreen, Screen
from study.shell.replay.head import Head
from study.shell.replay.marks import read_marks
from study.shell.replay.tape import Tape

Seen = list[tuple[int, Screen]]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> tuple[SessionRecording, Seen]:
    """A recording, and every screen that was shown meanwhile."""
    path, seen = seen_session(tmp_path_factory.mktemp("seen"), pause_s=0.005)
    return read_whole_session(path), seen


@pytest.fixture(scope="module")
def tape(session: tuple[SessionRecording, Seen]) -> Tape:
    """Its tape, with a fork of the session after nearly every input."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("study.shell.replay.tape.SPACING_S", 0.0005)
        made = Tape(session[0])
        made.read(1e9)
    assert made.forks > 20
    return made


def records_of(session: SessionRecording) -> list[RawRecord]:
    """Return all records but the writer's opening note."""
    return [raw for raw in session.raw() if raw.sequence]


def poses(head: Head) -> list[object]:
    """Return where the robots shown are drawn a third of a timestep later."""
    if not isinstance(head.screen, FleetScreen):
        return []
    now_ns = head.screen.t_ns + round(head.screen.timestep_seconds * 1e9 / 3)
    return [head.motion.pose(head.screen, tile, now_ns) for tile in head.screen.tiles]


def last_shown(seen: Seen) -> list[tuple[int, Screen]]:
    """Return the last screen of each moment."""
    return [list(group)[-1] for _, group in groupby(seen, key=lambda item: item[0])]


def test_every_screen_is_the_one_that_was_shown(session: tuple[SessionRecording, Seen]) -> None:
    """Input by input the same screens in the same order, and nothing else."""
    recording, seen = session
    head = Head()
    shown: list[Screen] = []
    for raw in recording.raw("input"):
        shown += head.feed(raw, decode(raw.topic, raw.data))  # type: ignore[arg-type]
    assert shown == [screen for _, screen in seen]
    assert {type(screen).__name__ for screen in shown} >= {
        "FleetScreen", "PageScreen", "SurveyScreen", "RevealScreen", "WaitScreen", "EndScreen",
    }  # fmt: skip


def test_going_forward_shows_each_moment(session: tuple[SessionRecording, Seen]) -> None:
    """At each time the screen is that which was shown last; it stays until the next."""
    recording, seen = session
    tape = Tape(recording)
    moments = last_shown(seen)
    for (t_ns, screen), (next_ns, _) in zip(moments, [*moments[1:], (2**62, None)], strict=True):
        for asked in (t_ns, (t_ns + next_ns) // 2 if next_ns < 2**62 else t_ns + 1, next_ns - 1):
            if t_ns <= asked < next_ns:
                assert tape.go_to(asked).screen == screen
    assert tape.is_read
    assert tape.difference == ""


@settings(max_examples=25)
@given(shares=st.lists(st.floats(0, 1), min_size=1, max_size=8))
def test_seeking_shows_what_playing_shows(
    session: tuple[SessionRecording, Seen], tape: Tape, shares: list[float]
) -> None:
    """In any order of times: the same screen, scores and motion as from the beginning."""
    recording, _ = session
    end = read_marks(recording).last_ns
    for share in shares:
        t_ns = round(share * end)
        found = tape.go_to(t_ns)
        fresh = Head()
        for raw in recording.raw("input"):
            given_input: Any = decode(raw.topic, raw.data)
            if given_input.t_ns > t_ns:
                break
            fresh.feed(raw, given_input)
        assert found.screen == fresh.screen
        assert found.scores.tolist() == fresh.scores.tolist()
        assert poses(found) == poses(fresh)


def test_scores_are_those_of_the_states_shown(
    session: tuple[SessionRecording, Seen], tape: Tape
) -> None:
    """At each answer of the fleet with scores these are shown; after the trial there are none."""
    recording, _ = session
    answers = [
        answer
        for _, answer in recording.records(FleetObserved.topic)
        if isinstance(answer, FleetObserved) and answer.scores.size
    ]
    assert len(answers) > 5
    same = 0
    for answer in answers:
        head = tape.go_to(answer.t_ns)
        if isinstance(head.screen, FleetScreen):
            same += 1
            assert head.scores.tolist() == answer.scores.tolist()
    assert same > 5
    assert tape.go_to(read_marks(recording).last_ns).scores.size == 0


def test_forks_are_bounded(
    session: tuple[SessionRecording, Seen], monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long a session is, only so many forks are kept, and seeking stays right."""
    monkeypatch.setattr("study.shell.replay.tape.SPACING_S", 0.0)
    monkeypatch.setattr("study.shell.replay.tape.MOST_FORKS", 9)
    recording, seen = session
    tape = Tape(recording)
    tape.read(1e9)
    assert tape.forks <= 9
    for t_ns, screen in reversed(last_shown(seen)[::7]):
        assert tape.go_to(t_ns).screen == screen


def test_a_resumed_session_is_replayed_across_its_parts(
    tmp_path: Path, session: tuple[SessionRecording, Seen]
) -> None:
    """To its end; the timeline marks where it went on, and no trial twice."""
    write_part(tmp_path, records_of(session[0])[:330])
    path = resume(find_boundary(study_loaded(), "P01", tmp_path), tmp_path)
    recording = read_whole_session(path)
    assert len(recording.parts) == 2
    tape, marks = Tape(recording), read_marks(recording)
    assert type(tape.go_to(marks.last_ns).screen).__name__ == "EndScreen"
    assert tape.difference == ""
    assert [fault.text.split(":")[0] for fault in marks.faults] == ["resumed"]
    assert len(marks.of_kind("trial")) == len(read_marks(session[0]).of_kind("trial"))

    # The first part alone is what there is; the second alone is refused.
    alone = tmp_path / "alone"
    alone.mkdir()
    path.rename(alone / path.name)
    with pytest.raises(RecordingError, match="part 1 is not beside it"):
        read_whole_session(alone / path.name)


def test_a_torn_recording_is_replayed_to_where_it_is_torn(
    tmp_path: Path, session: tuple[SessionRecording, Seen]
) -> None:
    """What is shown is what was shown; then it ends."""
    recording, seen = session
    torn = tmp_path / "torn.mcap"
    data = recording.path.read_bytes()
    torn.write_bytes(data[: len(data) * 2 // 3])
    left = read_whole_session(torn)
    assert not left.complete
    marks, tape = read_marks(left), Tape(left)
    assert 0 < marks.last_ns < read_marks(recording).last_ns
    for t_ns, screen in last_shown(seen):
        if t_ns < marks.last_ns:
            assert tape.go_to(t_ns).screen == screen


def test_a_recording_with_a_hole_ends_before_it(
    tmp_path: Path, session: tuple[SessionRecording, Seen]
) -> None:
    """Nothing is shown that would need what is missing, and words say where it ends."""
    recording, seen = session
    records = records_of(recording)
    write_part(tmp_path, records[:200])
    write_part(tmp_path, records[260:400], name="x", part=1)
    (tmp_path / "x.mcap").unlink()
    (first,) = tmp_path.glob("*.mcap")
    write_part(tmp_path, records[260:400], name=first.stem, part=2)
    holed = read_whole_session(first)
    assert holed.losses[0].first == 201
    tape, marks = Tape(holed), read_marks(holed)
    tape.read(1e9)
    assert "record 201 is missing" in tape.difference
    shown = dict(last_shown(seen))
    last = [t_ns for t_ns in shown if t_ns <= marks.last_ns][-2]
    assert tape.go_to(last).screen == shown[last]
    assert tape.go_to(2**62).t_ns <= marks.last_ns


def test_what_does_not_follow_is_not_shown(
    tmp_path: Path, session: tuple[SessionRecording, Seen]
) -> None:
    """Where an event differs from what the inputs give, the replay ends, and says why."""
    records = records_of(session[0])
    place = [n for n, raw in enumerate(records) if raw.topic == Timestep.topic][30]
    row: Any = decode(records[place].topic, records[place].data)
    other = dataclasses.replace(records[place], data=encode(dataclasses.replace(row, due_ns=1)))
    path = write_part(tmp_path, [*records[:place], other, *records[place + 1 :]])
    tape = Tape(read_whole_session(path))
    tape.read(1e9)
    assert f"record {place + 1}: event/timestep differs in due_ns" in tape.difference
    head = tape.go_to(2**62)
    assert head.last is not None
    assert head.last.sequence < place


def test_no_task_is_needed(tmp_path: Path, session: tuple[SessionRecording, Seen]) -> None:
    """A recording of a task that is not installed shows the same screens."""
    recording, seen = session
    records = records_of(recording)
    place = next(n for n, raw in enumerate(records) if raw.topic == SessionOpened.topic)
    opened: Any = decode(records[place].topic, records[place].data)
    toml = opened.protocol_toml.replace('name = "navigation"', 'name = "not_installed"')
    assert toml != opened.protocol_toml
    other = encode(dataclasses.replace(opened, protocol_toml=toml))
    records[place] = dataclasses.replace(records[place], data=other)
    path = write_part(tmp_path, records)
    tape = Tape(read_whole_session(path))
    for t_ns, screen in last_shown(seen)[::5]:
        assert tape.go_to(t_ns).screen == screen
    tape.read(1e9)
    assert tape.difference == ""
