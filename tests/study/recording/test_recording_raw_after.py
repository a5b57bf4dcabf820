"""Reading on after a record gives what reading from the beginning gives after it."""

from __future__ import annotations

from pathlib import Path

import pytest

from cut_sessions import resume, study_loaded, whole_session, write_part
from study.commands.resuming import find_boundary
from study.recording.parts import SessionRecording, read_session
from study.recording.reader import RawRecord


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> SessionRecording:
    """A session in one part."""
    return read_session(whole_session(tmp_path_factory.mktemp("whole"), pause_s=0.005))


def check(session: SessionRecording, step: int) -> None:
    """Check every ``step``-th record, and the last."""
    for families in (("input",), ("input", "event")):
        records = list(session.raw(*families))
        for place in [*range(0, len(records), step), len(records) - 1]:
            after = list(session.raw(*families, after=records[place]))
            assert after == records[place + 1 :]


def test_a_whole_session(whole: SessionRecording) -> None:
    """From any of its records on."""
    check(whole, 23)


def test_torn_and_resumed_sessions(tmp_path: Path, whole: SessionRecording) -> None:
    """Over the borders of parts, and where records were left out."""
    records = [raw for raw in whole.raw() if raw.sequence]
    write_part(tmp_path, records[:330])
    path = resume(find_boundary(study_loaded(), "P01", tmp_path), tmp_path)
    session = read_session(path)
    assert len(session.parts) == 2
    assert session.left_out_records
    check(session, 41)

    torn = tmp_path / "torn.mcap"
    data = whole.path.read_bytes()
    torn.write_bytes(data[: len(data) * 2 // 3])
    check(read_session(torn), 37)


def test_times_that_lead_astray_lose_nothing(whole: SessionRecording) -> None:
    """A record whose time is none of its chunk's is looked for from the beginning."""
    records = list(whole.raw("input"))
    for place in (5, len(records) // 2):
        for wrong_ns in (0, 2**62):
            raw = records[place]
            astray = RawRecord(raw.sequence, raw.topic, wrong_ns, raw.data)
            assert list(whole.raw("input", after=astray)) == records[place + 1 :]


def test_any_record_is_found_by_its_number(tmp_path: Path, whole: SessionRecording) -> None:
    """In one part or in several, with a time that leads to it or astray; others are not there."""
    records = [raw for raw in whole.raw() if raw.sequence]
    write_part(tmp_path, records[:330])
    resumed = read_session(resume(find_boundary(study_loaded(), "P01", tmp_path), tmp_path))
    assert resumed.left_out_records
    for session in (whole, resumed):
        for raw in [raw for raw in session.raw() if raw.sequence][::17]:
            for time_ns in (raw.log_time_ns, 0, 2**62):
                assert session.find(raw.topic, raw.sequence, time_ns) == raw
            assert session.find("event/no_such", raw.sequence, raw.log_time_ns) is None
    last = records[-1]
    assert whole.find(last.topic, last.sequence + 9, last.log_time_ns) is None
    kept = {raw.sequence for raw in resumed.raw()}
    left_out = next(raw for raw in records[:330] if raw.sequence not in kept)
    assert resumed.find(left_out.topic, left_out.sequence, left_out.log_time_ns) is None
