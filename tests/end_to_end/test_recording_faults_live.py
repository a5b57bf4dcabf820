"""Faults that really happen to `study run`: signals, a dead or stalled writer, a full disk."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from children import child_of
from patience import PATIENCE_S
from protocols import variant
from recording_parts import Merged, parts_in
from small_disk import fill, small_disk
from study.errors import StudyError
from study.events.events import Deviation, Paused, Resumed, SessionEnded, TrialStarted
from study.events.fields import Record
from study.events.inputs import RecordingInterrupted, TimestepDue
from study.recording.parts import read_session
from study.recording.reader import read_recording
from study.recording.wire import decode
from study.verification import verify_recording
from x11_driver import Hands, x_server

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals and mounts of Linux")


@contextmanager
def running(folder: Path, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """Start a session, and make sure that it ends."""
    home = folder.parent / f"{folder.name}_protocol"
    home.mkdir()
    protocol = variant(home, ("[practice]\ntimesteps = 10", "[practice]\ntimesteps = 300"))
    command = [sys.executable, "-m", "study.commands.main", "run", str(protocol)]
    study = subprocess.Popen(
        [*command, "-p", "P01", "-o", str(folder)],
        cwd=ROOT,
        env={**os.environ, "SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy", **environment},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield study
    finally:
        study.send_signal(signal.SIGCONT)
        study.kill()
        study.wait(10)
        if study.stderr:
            study.stderr.close()


def recorded(folder: Path) -> list[tuple[int, Record]]:
    """Return sequence and record of all that is on disk by now; nothing while a file moves."""
    try:
        rows = Merged(parts_in(folder)).raw("input", "event")
        return [(row.sequence, decode(row.topic, row.data)) for row in rows]
    except (StudyError, FileNotFoundError):
        return []


def wait_for(reached: Callable[[], bool], seconds: float = PATIENCE_S) -> None:
    deadline = time.monotonic() + seconds
    while not reached():
        assert time.monotonic() < deadline, "not reached in time"
        time.sleep(0.05)


def has(folder: Path, kind: type[Record]) -> bool:
    return any(isinstance(record, kind) for _, record in recorded(folder))


def timesteps_due(numbered: list[tuple[int, Record]]) -> int:
    return sum(isinstance(record, TimestepDue) for _, record in numbered)


def writer_of(study: subprocess.Popen[str]) -> int:
    """Return the process id of the study's present writer."""
    return child_of(study, "study.recording.writer")


def assert_replays(folder: Path) -> list[Record]:
    """Across the parts nothing is missing, and the events follow from the inputs."""
    merged = Merged(parts_in(folder))
    assert sorted(merged.rows) == list(range(1, len(merged.rows) + 1))
    verdict = verify_recording(merged)  # type: ignore[arg-type]
    assert verdict.matches, verdict.difference
    assert read_recording(parts_in(folder)[-1]).complete
    return [record for _, record in recorded(folder)]


@contextmanager
def in_mid_trial(folder: Path) -> Iterator[tuple[subprocess.Popen[str], Hands]]:
    """Run a session in a window, up to a trial that runs."""
    with x_server() as display, running(folder, DISPLAY=display, SDL_VIDEODRIVER="x11") as study:
        hands = Hands(display)
        hands.wait_for_window()

        def started() -> bool:
            hands.tap("return")
            time.sleep(0.2)
            return has(folder, TrialStarted)

        wait_for(started)
        yield study, hands
        hands.close()


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT])
def test_polite_signals_end_the_session_in_order(tmp_path: Path, sent: signal.Signals) -> None:
    """SIGTERM and SIGINT: status 3, a complete file, the reason in it."""
    folder = tmp_path / "recordings"
    with running(folder) as study:
        wait_for(lambda: has(folder, Record))
        time.sleep(0.3)
        study.send_signal(sent)
        assert study.wait(PATIENCE_S) == 3
    ended = assert_replays(folder)[-1]
    assert isinstance(ended, SessionEnded)
    reason = "Ctrl-C in the terminal" if sent is signal.SIGINT else sent.name
    assert (ended.complete, ended.reason) == (False, reason)
    assert [path.suffix for path in folder.glob("*.mcap*")] == [".mcap"]


@pytest.mark.parametrize("blow", [signal.SIGKILL, signal.SIGSTOP])
def test_a_lost_writer_costs_a_pause(tmp_path: Path, blow: signal.Signals) -> None:
    """The session pauses and a part begins; Enter goes on; nothing is missing."""
    folder = tmp_path / "recordings"
    with in_mid_trial(folder) as (study, hands):
        writer = writer_of(study)
        os.kill(writer, blow)
        wait_for(lambda: has(folder, Deviation))
        # It was killed by now, but on a busy machine it is not gone at once.
        wait_for(lambda: not Path(f"/proc/{writer}").exists())
        assert writer_of(study) != writer
        hands.tap("return")
        wait_for(lambda: has(folder, Resumed))
        study.send_signal(signal.SIGTERM)
        assert study.wait(PATIENCE_S) == 3
        # The experimenter is told at the terminal.
        assert study.stderr is not None
        assert "recording_interrupted" in study.stderr.read()
    names = [path.name for path in parts_in(folder)]
    assert [name.split(".", 1)[1] for name in names] == ["mcap.part", "mcap"]
    assert names[1].removesuffix("_part2.mcap") == names[0].removesuffix(".mcap.part")
    records = assert_replays(folder)
    # The file that was left as it was is explained, and is no problem.
    session = read_session(parts_in(folder)[0])
    assert session.problems == ()
    assert session.remarks[0].startswith("Part 1 was not closed; part 2 goes on from record ")
    paused = next(record for record in records if isinstance(record, Paused))
    assert paused.reason == "recording interrupted"
    deviation = next(record for record in records if isinstance(record, Deviation))
    started = next(record for record in records if isinstance(record, TrialStarted))
    assert (deviation.code, deviation.trial_id) == ("recording_interrupted", started.trial_id)
    assert sum(isinstance(record, RecordingInterrupted) for record in records) == 1


def test_a_writer_that_stood_still_goes_on(tmp_path: Path) -> None:
    """SIGSTOP and, before the writer is given up, SIGCONT: no part begins, and none is told of."""
    folder = tmp_path / "recordings"
    with in_mid_trial(folder) as (study, _):
        writer = writer_of(study)
        os.kill(writer, signal.SIGSTOP)
        time.sleep(3.0)
        os.kill(writer, signal.SIGCONT)
        wait_for(lambda: has(folder, Deviation))
        assert writer_of(study) == writer
        study.send_signal(signal.SIGTERM)
        assert study.wait(PATIENCE_S) == 3
        assert study.stderr is not None
        said = " ".join(study.stderr.read().split())
    assert [path.suffix for path in folder.glob("*.mcap*")] == [".mcap"]
    records = assert_replays(folder)
    deviation = next(record for record in records if isinstance(record, Deviation))
    assert deviation.code == "recording_interrupted"
    text = "the writer process wrote nothing for 0.9 s; "
    text += r"[1-5]\.[0-9] s later all records were on disk: nothing was lost"
    assert re.fullmatch(text, deviation.text), deviation.text
    assert re.search(rf"recording_interrupted, {text}\.", said), said


def test_a_study_that_stands_still_goes_on_without_a_burst(tmp_path: Path) -> None:
    """SIGSTOP and SIGCONT: what was sent is on disk, no step is caught up, no writer is killed."""
    folder = tmp_path / "recordings"
    with in_mid_trial(folder) as (study, _):
        study.send_signal(signal.SIGSTOP)
        on_disk: list[tuple[int, Record]] = []
        time.sleep(2.0)
        while len(on_disk) < len(recorded(folder)):
            on_disk = recorded(folder)
            time.sleep(1.0)
        study.send_signal(signal.SIGCONT)
        wait_for(lambda: timesteps_due(recorded(folder)) > timesteps_due(on_disk))
        time.sleep(1.0)
        study.send_signal(signal.SIGTERM)
        assert study.wait(PATIENCE_S) == 3
    assert len(parts_in(folder)) == 1
    records = assert_replays(folder)
    times = [record.t_ns for record in records]
    steps = range(len(on_disk), len(times))
    gap = next(place for place in steps if times[place] - times[place - 1] > 1_500_000_000)
    # All that was sent is on disk, but for the one input that may have been in flight.
    assert len(set(times[len(on_disk) : gap])) <= 1
    # Ten a second at most, beginning with the one that is late.
    due = [record.t_ns for record in records[gap:] if isinstance(record, TimestepDue)]
    assert due
    assert len(due) <= 2 + (due[-1] - due[0]) / 100_000_000


def test_a_full_disk_ends_the_session_with_status_4(tmp_path: Path) -> None:
    """The message says that the disk is full, what is safe and what to do."""
    with small_disk(tmp_path / "small") as folder:
        with running(folder) as study:
            wait_for(lambda: has(folder, Record))
            fill(folder)
            assert study.wait(PATIENCE_S) == 4
            assert study.stderr is not None
            said = study.stderr.read()
        assert "the disk is full" in said
        assert "It is safe up to" in said
        assert "Free space" in said
        assert [path.suffix for path in folder.glob("*.mcap*")] == [".part"]
        assert recorded(folder)
