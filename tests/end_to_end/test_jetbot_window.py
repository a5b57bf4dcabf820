"""The lap study in a real window, over the robot link to simulated robots in another process."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from analysis.commands.report import write_report
from command_line import study
from extras import need
from participant import Participant
from patience import PATIENCE_S
from protocols import ROOT, lap_study
from study.events.events import Deviation, StageEntered
from study.events.inputs import KeyChanged, RobotReported
from study.events.shell import Note
from study.recording.reader import read_recording
from study.robots.poses import Pose, PoseSource
from study.verification import verify
from twin_process import TwinProcess, running_twin, wait_until
from x11_driver import Hands, x_server

need("mujoco", "zmq")

ENVIRONMENT = {"PYTHONPATH": f"{ROOT}:{os.environ.get('PYTHONPATH', '')}"}
STOPPED_WITHIN_S = 0.5
"""From the key in the window to robots that stand: the way of the key and the motors' lag come on
top of the link's bound of 0.25 s."""
STILL_M = 0.002


class Onlooker:
    """Sees where all robots are, as motion capture does."""

    def __init__(self, source: PoseSource) -> None:
        self._source = source
        source.connect()

    def look(self, seconds: float) -> dict[int, float]:
        """Watch for a while; return how far from where it was each robot ended, metres."""
        before = self._now()
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            time.sleep(0.01)
            self._now()
        after = self._now()
        return {
            robot: math.hypot(pose.x - before[robot].x, pose.y - before[robot].y)
            for robot, pose in after.items()
        }

    def _now(self) -> dict[int, Pose]:
        wait_until(lambda: len(self._source.poses()) == 3)
        return self._source.poses()

    def close(self) -> None:
        """Look no longer."""
        self._source.close()


class Alarmed(Participant):
    """Presses F12 once in the large fleet; goes on when the robots have been released."""

    def watch(self, onlooker: Onlooker, twin: TwinProcess) -> None:
        """Look at the robots from outside."""
        self._onlooker, self._twin = onlooker, twin
        self.driven: dict[int, float] = {}
        self.stopping: dict[int, float] = {}
        self.afterwards: dict[int, float] = {}

    def _drive(self, stage: StageEntered) -> None:
        if stage.phase == 3 and not self.stopping:
            self._stop_all()
        super()._drive(stage)

    def _stop_all(self) -> None:
        hands = self._hands
        hands.tap("1")
        hands.key("up", down=True)
        self.driven = self._onlooker.look(1.5)
        hands.tap("f12")
        self.stopping = self._onlooker.look(STOPPED_WITHIN_S)
        # The key for driving is still held, and robots 2 and 3 would drive themselves.
        self.afterwards = self._onlooker.look(1.0)
        hands.key("up", down=False)
        released = study("robot-release", self._twin.robots_file)
        assert released.returncode == 0, released.stderr


@pytest.mark.acceptance
def test_laps_by_real_events_over_the_link(tmp_path: Path) -> None:
    """All is passed by real keys; F12 stops every robot, is on record, and the session goes on."""
    folder = tmp_path / "recordings"
    with running_twin(tmp_path / "keys", 3) as twin, x_server() as display:
        protocol = lap_study(tmp_path, twin.robots_file)
        environment = {
            **os.environ,
            **ENVIRONMENT,
            "DISPLAY": display,
            "SDL_VIDEODRIVER": "x11",
            "SDL_AUDIODRIVER": "dummy",
        }
        command = [sys.executable, "-m", "study.commands.main", "run", str(protocol), "-p", "P01"]
        program = subprocess.Popen([*command, "-o", str(folder)], env=environment, cwd=ROOT)
        hands = Hands(display)
        participant = Alarmed(hands, folder, program, mouse=False, seed=1)
        onlooker = Onlooker(twin.poses())
        participant.watch(onlooker, twin)
        try:
            participant.run(PATIENCE_S)
        finally:
            program.terminate()
            status = program.wait(PATIENCE_S)
            hands.close()
            onlooker.close()
    assert status == 0
    assert set(participant.driven) == {0, 1, 2}
    assert participant.driven[0] > 0.05, "robot 1 was not driven before the stop"
    assert max(participant.afterwards.values()) < STILL_M, participant.afterwards
    (path,) = folder.glob("*.mcap")
    _check(path, hands.sent, tmp_path / "report")


def _check(path: Path, sent: list[tuple[str, bool]], report: Path) -> None:
    """Check the recording: keys as sent, the stop, a replay; and that a report comes of it."""
    recording = read_recording(path)
    assert recording.complete
    records = [record for _, record in recording.records()]
    keys = [(each.key, each.down) for each in records if isinstance(each, KeyChanged)]
    # The page before the end may be confirmed twice; then the session is over before a key is up.
    assert keys == sent[: len(keys)]
    assert sent[len(keys) :] in ([], [("return", False)])
    assert any(isinstance(each, Note) and each.text == "emergency stop pressed" for each in records)
    reports = [
        (each.robot, each.stopped)
        for each in records
        if isinstance(each, RobotReported) and each.reason == "emergency"
    ]
    for robot in range(3):
        assert [stopped for number, stopped in reports if number == robot] == [True, False]
    noted = [each for each in records if isinstance(each, Deviation)]
    assert sum(each.code == "robot_stopped" for each in noted) >= 3
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    page = write_report([path], report).read_text()
    assert "Team laps per trial" in page
    assert "Manual" in page
    assert "Assisted" in page
