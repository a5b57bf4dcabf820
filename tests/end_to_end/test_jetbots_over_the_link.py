"""A whole session with simulated robots in another process: faults are survived and recorded."""

from __future__ import annotations

import os
import threading
from pathlib import Path

from command_line import study
from extras import need
from protocols import ROOT, jetbots
from study.events.events import Deviation, SessionEnded
from study.events.inputs import RobotReported
from study.recording.reader import read_recording
from twin_process import TwinProcess, running_twin

need("mujoco", "zmq")

ENVIRONMENT = {"PYTHONPATH": f"{ROOT}:{os.environ.get('PYTHONPATH', '')}"}


class Troubles(threading.Thread):
    """Loses a pose, freezes a camera and stops everything, for a second each, over and over."""

    def __init__(self, twin: TwinProcess) -> None:
        super().__init__()
        self._twin = twin
        self.ending = threading.Event()

    def run(self) -> None:
        """Go on until told otherwise."""
        while not self.ending.is_set():
            for fault in ("pose_lost 1", "camera_frozen 0"):
                for switch in ("on", "off"):
                    if self.ending.wait(1.0):
                        return
                    self._twin.tell(f"{fault} {switch}")


def test_a_session_survives_what_befalls_its_robots(tmp_path: Path) -> None:
    """Poses are lost and cameras freeze throughout; the session ends whole and says so."""
    with running_twin(tmp_path / "keys", 2) as twin:
        protocol = jetbots(tmp_path, twin.robots_file)
        troubles = Troubles(twin)
        threading.Timer(6.0, troubles.start).start()
        arguments = ("simulate", protocol, "--participants", "1", "-o", tmp_path / "out")
        done = study(*arguments, environment=ENVIRONMENT)
        troubles.ending.set()
        assert done.returncode == 0, done.stderr
    path = next((tmp_path / "out").glob("*.mcap"))
    records = [record for _, record in read_recording(path).records()]
    ended = [record for record in records if isinstance(record, SessionEnded)]
    assert [record.complete for record in ended] == [True]
    reports = [record for record in records if isinstance(record, RobotReported)]
    stopped = {(report.robot, report.reason) for report in reports if report.stopped}
    assert {(1, "pose_lost"), (0, "camera_stale")} <= stopped
    deviations = [
        record
        for record in records
        if isinstance(record, Deviation) and record.code == "robot_stopped"
    ]
    assert len(deviations) == sum(report.stopped for report in reports)
    replayed = study("replay", "--verify", path, environment=ENVIRONMENT)
    assert replayed.returncode == 0, replayed.stderr + replayed.stdout


def test_a_session_does_not_begin_without_its_robots(tmp_path: Path) -> None:
    """With the twin gone, `study run` says which robot does not answer, and records nothing."""
    with running_twin(tmp_path / "keys", 2) as twin:
        protocol = jetbots(tmp_path, twin.robots_file)
    done = study("run", protocol, "-p", "P01", "-o", tmp_path / "out", environment=ENVIRONMENT)
    assert done.returncode == 2
    assert "robot1 did not answer" in done.stderr + done.stdout
    assert not list((tmp_path / "out").glob("*.mcap"))
