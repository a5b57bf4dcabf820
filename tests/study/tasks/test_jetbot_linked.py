"""The task over the robot link, against the digital twin in another process."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from extras import need
from lap_driver import FORWARD, IDLE, TURN_LEFT
from study.errors import StudyError
from study.events.codes import Outcome
from study.robots import robots_file
from study.robots.emergency import EmergencyButton
from study.robots.fleet import RobotFleet
from study.robots.safety import Bounds
from study.session.effects import StartFleet, StepFleet
from study.shell.fleet_host import FleetHost
from study.tasks import jetbot
from study.tasks.base import PicturedTask, ReportingTask, RobotReport
from twin_process import TwinProcess, running_twin

need("mujoco", "zmq")

ROBOTS = 2
EVERY = np.ones(ROBOTS, np.bool_)
SEEDS = np.zeros(ROBOTS, np.uint64)


@pytest.fixture
def twin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[TwinProcess]:
    """A twin, and bounds that a busy test run keeps."""
    wide = Bounds(link=0.6, pose=0.5, camera=1.5)
    monkeypatch.setattr(
        robots_file, "RobotFleet", lambda clients, poses: RobotFleet(clients, poses, wide)
    )
    with running_twin(tmp_path / "keys", ROBOTS) as running:
        yield running


def test_a_fleet_is_stepped_over_the_link(twin: TwinProcess) -> None:
    """What keys say is driven, in real time; who is not active stands."""
    settings = {"link": str(twin.robots_file), "cameras": True}
    assert jetbot.describe(settings).resimulable == "no"
    task = jetbot.create(ROBOTS, settings)
    assert isinstance(task, ReportingTask)
    try:
        before = task.reset(EVERY, SEEDS)
        began = time.monotonic()
        for _ in range(12):
            step = task.step(np.array([FORWARD, FORWARD], np.int32), np.array([True, False]))
        assert 12 * 0.8 / 8 <= time.monotonic() - began < 12 / 8 + 2
        assert step.states[0, 0] - before[0, 0] > 0.15
        assert np.abs(step.states[1] - before[1]).max() < 0.01
        for _ in range(8):
            step = task.step(np.array([IDLE, TURN_LEFT], np.int32), EVERY)
        assert step.states[1, 2] - before[1, 2] > 0.5
        assert step.outcomes.tolist() == [Outcome.RUNNING] * ROBOTS
        assert isinstance(task, PicturedTask)
        assert task.pictures().shape == (ROBOTS, 120, 160, 3)
        assert task.take_reports() == ()
    finally:
        task.close()
        task.close()


def test_fleets_of_two_sizes_share_robots_and_faults_are_reported(twin: TwinProcess) -> None:
    """As a session asks: a fleet of one, then of two; a lost pose comes with the answer."""
    host = FleetHost("jetbot", {"link": str(twin.robots_file)})
    try:
        for robots in (1, 2):
            host.answer(StartFleet(1, 1, robots, SEEDS[:robots], "uniform_random", 0, ""))
        twin.tell("pose_lost 2 on")
        reports: list[RobotReport] = []
        for number in range(16):
            step = StepFleet(
                number + 10,
                np.array([FORWARD, FORWARD], np.int32),
                EVERY,
                np.zeros(ROBOTS, np.bool_),
                SEEDS,
            )
            reports += host.answer(step).reports
        assert [(r.robot, r.stopped, r.reason) for r in reports] == [(1, True, "pose_lost")]
        assert 0 <= reports[0].age_s < 1
        assert "robot 2 stopped" in reports[0].text
    finally:
        host.close()


def test_the_emergency_button_stops_robots_that_are_driven(twin: TwinProcess) -> None:
    """Pressed beside a fleet that drives on, it stops all; released, they drive again."""
    settings = {"link": str(twin.robots_file)}
    jetbot.check_live(settings)
    button = jetbot.open_emergency(settings)
    assert isinstance(button, EmergencyButton)
    task = jetbot.create(ROBOTS, settings)
    assert isinstance(task, ReportingTask)
    forward = np.full(ROBOTS, FORWARD, np.int32)
    try:
        task.reset(EVERY, SEEDS)
        task.step(forward, EVERY)
        button.press()
        for _ in range(4):
            before = task.step(forward, EVERY).states
        for _ in range(3):
            step = task.step(forward, EVERY)
        assert np.abs(step.states - before).max() < 0.005
        reasons = [report.reason for report in task.take_reports() if report.stopped]
        assert reasons == ["emergency"] * ROBOTS
        assert button.without_answer(stopped=False) == []
        for _ in range(12):
            step = task.step(forward, EVERY)
        assert (step.states[:, 0] - before[:, 0] > 0.05).all()
    finally:
        task.close()
        button.close()


def test_too_few_robots_are_told(twin: TwinProcess) -> None:
    """A fleet larger than the file lists is refused, and the robots are let go."""
    with pytest.raises(StudyError, match="3 robots are to drive"):
        jetbot.create(3, {"link": str(twin.robots_file)})
    jetbot.create(2, {"link": str(twin.robots_file)}).close()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[", "not TOML"),
        ("operator_key = 'k'\nrobots = []\n", "robots"),
        (
            "operator_key = 'k'\n[[robots]]\nname = 'a'\naddress = 'ipc:///tmp/x'\n"
            "public_key = 'x'\n[poses]\nkind = 'twin'\naddress = 'tcp://h:1'\npublic_key = 'x'\n",
            "address",
        ),
    ],
)
def test_wrong_files_are_refused_in_words(tmp_path: Path, text: str, said: str) -> None:
    """What is wrong with a list of robots is said."""
    path = tmp_path / "robots.toml"
    path.write_text(text)
    with pytest.raises(StudyError, match=said):
        jetbot.create(1, {"link": str(path)})
