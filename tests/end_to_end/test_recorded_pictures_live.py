"""A session that records its pictures as `study run` does, and one killed with its writer."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from children import child_of
from operated_window import OperatedWindow
from patience import PATIENCE_S
from pictured_session import RECORDED
from protocols import FASTER_CARTS, ROOT, SHORT_CARTS, variant
from study.commands.composing import PICTURES_WAIT_NS, keeps_up
from study.commands.enrolling import Enrolled
from study.commands.running import Seat, run_session
from study.commands.simulating import simulated_assignments
from study.events.inputs import FleetObserved
from study.events.shell import Note, PicturesTaken, TrialTiming
from study.loading import load_protocol
from study.protocol import StudyPart
from study.recording.failover import FailoverRecorder
from study.recording.parts import read_whole_session
from study.recording.reader import read_recording
from study.recording.salvage import salvage
from study.shell.replay.recorded_pictures import RecordedPictures
from study.shell.window import Window
from study.verification import verify

pytest.importorskip("gymnasium")


class SimulatedSeat(Seat):
    """Where a simulated participant takes the person's place."""

    def open_window(self, study: StudyPart) -> Window:
        """Open a window without a display."""
        return OperatedWindow((1280, 960), seed=5)


class NoRegister(Enrolled):
    """Nobody is enrolled."""

    def __init__(self) -> None:
        """There is nothing to lease."""

    def begin(self) -> None:
        """Nothing is noted."""


def test_a_session_records_what_its_window_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the real clock, with the real writer: each answer's pictures, and punctual timesteps."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    protocol = variant(tmp_path, *SHORT_CARTS, FASTER_CARTS, base="cart_pole")
    protocol.write_text(protocol.read_text() + RECORDED)
    loaded = load_protocol(str(protocol))
    (assignment,) = simulated_assignments(loaded, 1, seed=5)
    done = run_session(loaded, assignment, tmp_path / "out", SimulatedSeat(), NoRegister())
    assert done.outcome == "complete"
    (path,) = done.paths
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    recording = read_recording(path)
    assert recording.complete
    taken = [r for _, r in recording.records(PicturesTaken.topic) if isinstance(r, PicturesTaken)]
    answers = [r for _, r in recording.records(FleetObserved.topic)]
    assert {record.t_ns for record in taken} <= {record.t_ns for record in answers}
    # Of phase four nobody sees anything.
    seen = [r for r in answers if r.t_ns <= taken[-1].t_ns]
    assert len(taken) > 0.95 * len(seen)
    assert not [r for _, r in recording.records(Note.topic) if "pictures" in getattr(r, "text", "")]
    timings = [r for _, r in recording.records(TrialTiming.topic) if isinstance(r, TrialTiming)]
    means = [timing.timestep_mean for timing in timings if timing.timesteps > 20]
    assert np.mean(means) == pytest.approx(0.05, rel=0.2)
    found = RecordedPictures(read_whole_session(path))
    for record in taken[::10]:
        pictures = found.at(record.t_ns, record.robots)
        assert pictures is not None
        for robot in record.shown.tolist():
            picture = pictures[robot]
            assert picture is not None
            assert picture.shape == (record.height, record.width, 3)


def test_a_disk_that_is_behind_gets_no_pictures(tmp_path: Path) -> None:
    """How long the oldest record waits decides: nothing waits, or it does since two seconds."""
    recorder = FailoverRecorder.start(tmp_path, "waits", {}, {})
    assert keeps_up(recorder, 5_000_000_000)
    recorder.write(Note(0, "not on disk yet"), 1_000_000_000)
    assert recorder.unsaved_log_time_ns == 1_000_000_000
    assert keeps_up(recorder, 1_000_000_000 + PICTURES_WAIT_NS - 1)
    assert not keeps_up(recorder, 1_000_000_000 + PICTURES_WAIT_NS)
    assert recorder.ensure_durable(PATIENCE_S)
    assert keeps_up(recorder, 10**18)
    recorder.close()


@pytest.mark.skipif(sys.platform != "linux", reason="signals of Linux")
def test_a_killed_recording_shows_its_pictures(tmp_path: Path) -> None:
    """Study and writer killed at once: what is in the .part is shown, and can be recovered."""
    script = ROOT / "tests" / "support" / "pictured_session.py"
    search_path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    study = subprocess.Popen(
        [sys.executable, str(script), str(tmp_path)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": search_path},
        text=True,
    )
    try:
        writer = child_of(study, "study.recording.writer")
        deadline = time.monotonic() + PATIENCE_S
        while sum(part.stat().st_size for part in tmp_path.glob("*.part")) < 150_000:
            assert time.monotonic() < deadline
            assert study.poll() is None
            time.sleep(0.005)
        os.kill(writer, signal.SIGKILL)
    finally:
        study.kill()
        study.wait(PATIENCE_S)
    (part,) = tmp_path.glob("*.mcap.part")
    session = read_whole_session(part)
    assert not session.complete
    found = RecordedPictures(session)
    assert found.moments > 10
    mended = read_whole_session(salvage(part, tmp_path / "mended.mcap").path)
    again, shown = RecordedPictures(mended), 0
    assert again.moments == found.moments
    for _, record in mended.records(PicturesTaken.topic):
        assert isinstance(record, PicturesTaken)
        pictures = again.at(record.t_ns, record.robots)
        assert pictures is not None
        assert all(pictures[robot] is not None for robot in record.shown.tolist())
        shown += 1
    assert shown > 10
