"""A session that breaks off anywhere goes on at the last boundary, and nothing counts twice."""

from __future__ import annotations

import dataclasses
import hashlib
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import cut_sessions
from analysis.recordings import load_recordings
from cut_sessions import resume, study_loaded, whole_session, write_part
from patience import PATIENCE_S
from protocols import variant
from study.commands.composing import start_failover_recorder
from study.commands.enrolling import assign
from study.commands.resuming import End, find_boundary, last_session
from study.errors import RecordingError, StudyError
from study.events.events import (
    Deviation,
    FitApplied,
    StageEntered,
    Timestep,
    TrialEnded,
    TrialStarted,
)
from study.events.inputs import FitCompleted, SessionResumed
from study.loading import load_protocol
from study.recording.file_lock import hold
from study.recording.parts import SessionRecording, base_name, read_session
from study.recording.reader import RawRecord, read_recording
from study.recording.wire import decode, encode
from study.verification import verify

Place = tuple[int, int, str, int]
T = TypeVar("T")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> SessionRecording:
    """A session that nobody killed."""
    return read_session(whole_session(tmp_path_factory.mktemp("undisturbed")))


@pytest.fixture(scope="module")
def records(undisturbed: SessionRecording) -> list[RawRecord]:
    """Its records, without the opening note."""
    return [raw for raw in undisturbed.raw() if raw.sequence]


def of_type(recording: Any, record_type: type[T]) -> list[T]:
    """Return all records of a type."""
    topic: str = record_type.topic  # type: ignore[attr-defined]
    return [record for _, record in recording.records(topic) if isinstance(record, record_type)]


def place(trial: TrialStarted) -> Place:
    """Return where in the study a fleet run belongs."""
    return trial.phase, trial.block, trial.condition, trial.trial


def states_key(trial: TrialStarted) -> tuple[Place, bytes]:
    """Return where a fleet run belongs and where its robots started."""
    return place(trial), trial.states.tobytes()


def check_whole(path: Path, parts: int, undisturbed: SessionRecording) -> SessionRecording:
    """Check what holds of every session that was resumed and driven to its end."""
    session = read_session(path)
    assert session.complete, session.problems
    assert len(session.parts) == parts
    everything = [raw for part in session.parts for raw in part.raw() if raw.sequence]
    assert [raw.sequence for raw in everything] == list(range(1, len(everything) + 1))
    times = [decode(raw.topic, raw.data).t_ns for raw in everything]
    assert times == sorted(times)
    kept = [raw for raw in session.raw() if raw.sequence]
    assert len(kept) + session.left_out_records == len(everything)

    for part in session.parts:
        verdict = verify(part.path)
        assert verdict.matches, verdict.difference
        assert verdict.parts == parts
        assert not verdict.problems

    started = of_type(session, TrialStarted)
    completed = [ended.trial_id for ended in of_type(session, TrialEnded) if ended.complete]
    assert [trial.trial_id for trial in started] == completed
    assert list(map(states_key, started)) == list(
        map(states_key, of_type(undisturbed, TrialStarted))
    )
    ids = [trial.trial_id for part in session.parts for trial in of_type(part, TrialStarted)]
    assert len(set(ids)) == len(ids)
    assert len(ids) == len(started) + session.left_out_trials
    rows = sum(len(run["t_ns"]) for run in session.columns(Timestep.topic))
    assert rows == len(of_type(session, Timestep))
    # A resume that broke off before it was recorded in full is itself gone back behind.
    resumes = of_type(session, SessionResumed)
    assert [d.code for d in of_type(session, Deviation)] == ["resumed"] * len(resumes)
    assert resumes[-1].part == parts
    return session


def cut_and_resume(
    folder: Path, records: list[RawRecord], cut: int
) -> tuple[Path, list[tuple[str, str]]]:
    """Break a session off after some records and resume it; return the part and fits restored."""
    write_part(folder, records[:cut])
    boundary = find_boundary(study_loaded(), "P01", folder)
    hashes = [(fit.artefact_id, hashlib.sha256(fit.weights).hexdigest()) for fit in boundary.fits]
    return resume(boundary, folder), hashes


@settings(max_examples=6, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.floats(0, 1), then=st.none() | st.floats(0, 1))
def test_cut_anywhere_once_or_twice(
    where: float, then: float | None, undisturbed: SessionRecording, records: list[RawRecord]
) -> None:
    """Each trial is completed once, from the same starts; fits, times and numbers go on."""
    # The first stage is entered with the third record.
    cut = 3 + round(where * (len(records) - 4))
    with tempfile.TemporaryDirectory() as given_folder:
        folder = Path(given_folder)
        path, hashes = cut_and_resume(folder, records, cut)
        fitted = {
            applied.artefact_id: applied.weights_sha256
            for applied in (
                decode(raw.topic, raw.data) for raw in records[: cut_boundary(records, cut)]
            )
            if isinstance(applied, FitApplied)
        }
        assert dict(hashes) == fitted
        if then is None:
            check_whole(path, 2, undisturbed)
            return
        second = [raw for raw in read_recording(path).raw() if raw.sequence]
        path.unlink()
        later = second[: round(then * (len(second) - 2))]
        write_part(folder, later, base_name(path), 2)
        path = resume(find_boundary(study_loaded(), "P01", folder), folder)
        assert path.name.endswith("_part3.mcap")
        check_whole(path, 3, undisturbed)


def cut_boundary(records: list[RawRecord], cut: int) -> int:
    """Return how many of the records before a cut are in force: up to the last stage's entry."""
    entries = [
        number for number, raw in enumerate(records[:cut]) if raw.topic == "event/stage_entered"
    ]
    return entries[-1] + 1


def test_every_kind_of_stage_can_break_off(
    tmp_path: Path, undisturbed: SessionRecording, records: list[RawRecord]
) -> None:
    """Every kind of stage, preparations and the last screen among them, is begun anew."""
    kinds: dict[tuple[str, bool], int] = {}
    for number, raw in enumerate(records):
        if raw.topic == "event/stage_entered":
            entered: Any = decode(raw.topic, raw.data)
            kinds.setdefault((entered.kind, entered.phase == 4), number + 2)
    kinds["thanks", True] = len(records) - 2
    assert len(kinds) == 10
    for index, cut in enumerate(kinds.values()):
        folder = tmp_path / str(index)
        path, _ = cut_and_resume(folder, records, cut)
        check_whole(path, 2, undisturbed)


def test_killed_processes_are_resumed(tmp_path: Path, undisturbed: SessionRecording) -> None:
    """Sessions of a process that gets SIGKILL at random moments go on to the same trials."""
    chance = random.Random(4)
    for number in range(2):
        folder = tmp_path / str(number)
        command = [sys.executable, cut_sessions.__file__, str(folder), "0.02"]
        study = subprocess.Popen(command, start_new_session=True)
        deadline = time.monotonic() + PATIENCE_S
        while not _reached_a_stage(folder) and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(5.0 * chance.random())
        study.kill()
        study.wait()
        (path,) = _settled(folder)
        if read_recording(path).complete and study.returncode == 0:
            continue
        path = resume(find_boundary(study_loaded(), "P01", folder), folder)
        check_whole(path, 2, undisturbed)


def _reached_a_stage(folder: Path) -> bool:
    """Return whether anything that can be resumed is on disk."""
    try:
        return any(
            of_type(read_session(path), StageEntered)
            for path in (*folder.glob("*.part"), *folder.glob("*.mcap"))
        )
    except (StudyError, FileNotFoundError):
        return False


def _settled(folder: Path) -> list[Path]:
    """Return the files once no writer is at work."""
    deadline = time.monotonic() + PATIENCE_S
    while list(folder.glob("*.part")) and time.monotonic() < deadline:
        time.sleep(0.05)
    return list(folder.glob("*.mcap"))


def test_interruption_is_a_deviation_with_its_gap(tmp_path: Path, records: list[RawRecord]) -> None:
    """The gap of wall time is recorded, and where the session went on."""
    path, _ = cut_and_resume(tmp_path, records, 250)
    (deviation,) = of_type(read_session(path), Deviation)
    assert deviation.code == "resumed"
    assert deviation.text == "part 2 goes on after 7.5 s at trial, phase 2"
    assert deviation.trial_id == -1


def test_analysis_sees_one_session(
    tmp_path: Path, undisturbed: SessionRecording, records: list[RawRecord]
) -> None:
    """From the folder or from any part, with torn parts; trials broken off are counted only."""
    path, _ = cut_and_resume(tmp_path, records, 330)
    first = tmp_path / f"{base_name(path)}.mcap"
    first.rename(first.with_name(f"{first.name}.part"))
    for given_paths in ([tmp_path], [path]):
        study = load_recordings(given_paths)
        (session,) = study.sessions
        assert not study.set_aside
        assert session.complete
        assert session.left_out_trials == 1
        assert len(session.trials) == len(of_type(undisturbed, TrialStarted))
        assert all(end.complete for end in session.trial_ends.values())


def test_time_and_numbers_go_on_after_all_that_is_recorded() -> None:
    """The first input of the next part tells number, boundary and gap; a clock may go back."""
    end = End(part=2, sequence=40, t_ns=9, log_time_ns=1_000)
    first = end.resumed(31, 10, 2_500_001_000)
    assert (first.part, first.after_sequence, first.t_ns, first.gap_seconds) == (3, 31, 10, 2.5)
    assert end.resumed(31, 10, 0).gap_seconds == 0.0


# What is refused


def test_unknown_participant_is_refused(tmp_path: Path, records: list[RawRecord]) -> None:
    """Nobody's session, or that of somebody else, cannot be gone on with."""
    with pytest.raises(StudyError, match='no recording of participant "P01"'):
        find_boundary(study_loaded(), "P01", tmp_path)
    write_part(tmp_path, records[:100])
    with pytest.raises(StudyError, match='no recording of participant "P02"'):
        find_boundary(study_loaded(), "P02", tmp_path)


def test_who_broke_off_before_the_session_began_starts_it(
    tmp_path: Path, records: list[RawRecord]
) -> None:
    """As where Ctrl-C came before the first record: what lies there needs no moving."""
    name = write_part(tmp_path, records[:0]).name
    with pytest.raises(StudyError, match='no recording of participant "P01"') as caught:
        find_boundary(study_loaded(), "P01", tmp_path)
    began = "broke off before the session began: start it without --resume."
    assert caught.value.hint == f"{name} {began}"


def test_complete_session_is_refused(tmp_path: Path, records: list[RawRecord]) -> None:
    """There is nothing to go on with."""
    write_part(tmp_path, records)
    with pytest.raises(StudyError, match="is complete: smoke_P01"):
        find_boundary(study_loaded(), "P01", tmp_path)


def test_changed_protocol_is_refused_with_both_hashes(
    tmp_path: Path, records: list[RawRecord]
) -> None:
    """One byte of difference is too much; the message names what was given and recorded."""
    write_part(tmp_path / "recordings", records[:100])
    other = load_protocol(str(variant(tmp_path, ("dwell = 15", "dwell = 14"))))
    with pytest.raises(StudyError, match="is not the protocol") as caught:
        find_boundary(other, "P01", tmp_path / "recordings")
    assert other.sha256 in caught.value.message
    assert study_loaded().sha256 in caught.value.message


def test_newer_format_is_refused(
    tmp_path: Path, records: list[RawRecord], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file of the participant that a newer program wrote is not passed over."""
    with monkeypatch.context() as newer:
        newer.setattr("study.recording.opening.FORMAT_VERSION", 2)
        write_part(tmp_path, records[:100])
    with pytest.raises(RecordingError, match="format version 2"):
        find_boundary(study_loaded(), "P01", tmp_path)


def test_session_being_written_is_refused(
    tmp_path: Path, records: list[RawRecord], monkeypatch: pytest.MonkeyPatch
) -> None:
    """While a process holds a file's lock nobody else goes on with its session."""
    monkeypatch.setattr("study.commands.resuming.WRITER_PATIENCE_S", 0.2)
    finished = write_part(tmp_path, records[:100])
    unfinished = finished.rename(finished.with_name(finished.name + ".part"))
    with unfinished.open("rb") as stream:
        hold(stream.fileno())
        with pytest.raises(StudyError, match="is still being written"):
            find_boundary(study_loaded(), "P01", tmp_path)
    assert find_boundary(study_loaded(), "P01", tmp_path).after_sequence <= 100


def test_changed_weights_are_refused(tmp_path: Path, records: list[RawRecord]) -> None:
    """Weights that are not those applied are found by their hash."""
    forged: list[RawRecord] = []
    for raw in records:
        data = raw.data
        if raw.topic == FitCompleted.topic:
            fit: Any = decode(raw.topic, raw.data)
            data = encode(dataclasses.replace(fit, weights=fit.weights + b"!"))
        forged.append(dataclasses.replace(raw, data=data))
    write_part(tmp_path, forged[:300])
    with pytest.raises(RecordingError, match="the weights of policy:phase_one have the SHA-256"):
        find_boundary(study_loaded(), "P01", tmp_path)


def test_other_events_are_refused(tmp_path: Path, records: list[RawRecord]) -> None:
    """A session whose events this program does not repeat cannot be gone on with."""
    place_of = next(n for n, raw in enumerate(records) if raw.topic == Timestep.topic)
    row: Any = decode(records[place_of].topic, records[place_of].data)
    other = dataclasses.replace(records[place_of], data=encode(dataclasses.replace(row, due_ns=1)))
    write_part(tmp_path, [*records[:place_of], other, *records[place_of + 1 : 300]])
    with pytest.raises(RecordingError, match=f"does not replay: record {place_of + 1}"):
        find_boundary(study_loaded(), "P01", tmp_path)


def test_session_without_a_stage_is_refused(tmp_path: Path, records: list[RawRecord]) -> None:
    """Two records are no beginning to go on from."""
    write_part(tmp_path, records[:2])
    with pytest.raises(RecordingError, match="before the first stage"):
        find_boundary(study_loaded(), "P01", tmp_path)


def test_later_part_alone_is_refused(tmp_path: Path, records: list[RawRecord]) -> None:
    """Without part 1 nothing can be restored or verified; the message says what to do."""
    path, _ = cut_and_resume(tmp_path, records, 200)
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.copy(path, alone)
    with pytest.raises(RecordingError, match="part 1 is not beside it"):
        verify(alone / path.name)
    with pytest.raises(StudyError) as caught:
        load_recordings([alone])
    first = f"{path.name.removesuffix('_part2.mcap')}.mcap"
    assert caught.value.message.splitlines()[1:] == [
        f"  {path.name}: it is a later part, and part 1 is not beside it: {first}"
    ]
    assert not read_session(alone / path.name).complete
    assert last_session(study_loaded(), "P01", alone) is None


def test_broken_off_participant_is_told_of_resume(tmp_path: Path, records: list[RawRecord]) -> None:
    """Who starts a participant anew learns that the session could go on; not if it is complete."""
    write_part(tmp_path / "broken", records[:100])
    with pytest.raises(StudyError, match="not complete") as caught:
        assign(study_loaded(), "P01", tmp_path / "broken")
    assert "--resume" in caught.value.hint
    write_part(tmp_path / "whole", records)
    with pytest.raises(StudyError, match="already has a recording") as caught:
        assign(study_loaded(), "P01", tmp_path / "whole")
    assert "--resume" not in caught.value.hint


def test_last_of_several_sessions_is_meant(tmp_path: Path, records: list[RawRecord]) -> None:
    """Of a participant who took part twice the later session goes on."""
    write_part(tmp_path, records)
    first: Any = decode(records[0].topic, records[0].data)
    later = dataclasses.replace(first, started_utc="2026-01-02T00:00:00+00:00", session_id="1" * 16)
    again = [dataclasses.replace(records[0], data=encode(later)), *records[1:150]]
    loaded = study_loaded()
    recorder = start_failover_recorder(tmp_path, loaded, later)
    for raw in again:
        recorder.write(decode(raw.topic, raw.data), raw.log_time_ns)
    recorder.close()
    boundary = find_boundary(loaded, "P01", tmp_path)
    assert boundary.opened.session_id == "1" * 16
