"""The digital twin in a process of its own: laps over the link, and every fault stops robots."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from extras import need
from lap_driver import heading_error
from study.arena.course import TWO_BUCKETS
from study.arena.laps import Progress, advance
from study.errors import StudyError
from study.robots.client import Action
from study.robots.fleet import RobotFleet
from study.robots.link import STOP_BOUND_S
from study.robots.safety import Bounds, SafetyChange, StopReason
from twin_process import TwinProcess, running_twin, twin_keys, wait_until

need("mujoco", "zmq")

ROBOTS = 2
COASTING_S = 0.25
"""From motors that are told to stop to a body that stands, and to the pose that says so."""

SLACK_S = 0.1
"""The supervisor's look and the command's way."""

# A process may wait long for its turn beside a busy test run; the bounds must hold anyhow.
BOUNDS = Bounds(link=0.5, pose=0.4, camera=0.8)


@pytest.fixture
def twin(tmp_path: Path) -> Iterator[TwinProcess]:
    """A twin of two robots."""
    with running_twin(tmp_path / "keys", ROBOTS) as running:
        yield running


@pytest.fixture
def fleet(twin: TwinProcess) -> Iterator[RobotFleet]:
    """Its robots, live."""
    made = twin.fleet(BOUNDS)
    made.connect(20.0)
    yield made
    made.disconnect()


def drive(fleet: RobotFleet, seconds: float, *robots: int) -> None:
    """Drive robots in a circle."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        fleet.send_action({robot: Action(0.2, 1.0) for robot in robots})
        time.sleep(0.05)


def moves(fleet: RobotFleet, robot: int) -> bool:
    """Say whether a robot's pose changes."""
    before = fleet.poses()[robot]
    time.sleep(0.06)
    now = fleet.poses()[robot]
    return math.dist((before.x, before.y), (now.x, now.y)) > 0.002


def test_laps_over_the_link(fleet: RobotFleet) -> None:
    """A robot driven by what the link tells goes round; gates are passed in order."""
    progress = Progress()
    before = fleet.poses()[0]
    until = time.monotonic() + 8.0
    while time.monotonic() < until:
        pose = fleet.poses()[0]
        progress = advance(TWO_BUCKETS, progress, (before.x, before.y), (pose.x, pose.y))
        before = pose
        error = heading_error(pose.x, pose.y, pose.heading)
        fleet.send_action({0: Action(0.5 if abs(error) < 0.6 else 0.1, 3 * error)})
        time.sleep(0.02)
    assert progress.passed >= 1 or progress.laps
    assert fleet.take_changes() == []


@pytest.mark.parametrize(
    ("fault", "cure", "reason", "bound"),
    [
        ("pose_lost 1 on", "pose_lost 1 off", StopReason.POSE_LOST, BOUNDS.pose),
        ("camera_frozen 1 on", "camera_frozen 1 off", StopReason.CAMERA_STALE, BOUNDS.camera),
        ("camera_dead 1 on", "camera_dead 1 off", StopReason.CAMERA_STALE, BOUNDS.camera),
        ("battery 1 0.05", "battery 1 1", StopReason.BATTERY_FLAT, 0.1),
    ],
)
def test_a_fault_stops_its_robot_alone(
    twin: TwinProcess, fleet: RobotFleet, fault: str, cure: str, reason: StopReason, bound: float
) -> None:
    """It is told and stands within the bound, while the other drives; cured, it drives again."""
    drive(fleet, 0.5, 0, 1)
    twin.tell(fault)
    began = time.monotonic()
    changes: list[SafetyChange] = []
    while time.monotonic() < began + bound + 1.0 and not changes:
        fleet.send_action({robot: Action(0.2, 1.0) for robot in (0, 1)})
        time.sleep(0.01)
        changes += [change for change in fleet.take_changes() if change.reason == reason]
    assert [(change.robot, change.reason, change.began) for change in changes] == [
        (0, reason, True)
    ]
    assert changes[0].at - began < bound + SLACK_S
    sent = fleet.send_action({robot: Action(0.2, 1.0) for robot in (0, 1)})
    assert (sent[0], sent[1]) == (Action(), Action(0.2, 1.0))
    drive(fleet, SLACK_S, 0, 1)
    status = fleet.get_observation()[0].status
    assert status is not None
    assert (status.linear, status.angular) == (0.0, 0.0)
    if reason != StopReason.POSE_LOST:
        drive(fleet, COASTING_S, 0, 1)
        assert not moves(fleet, 0)
    twin.tell(cure)
    wait_until(lambda: not fleet.reasons()[0])
    drive(fleet, 0.5, 0, 1)
    status = fleet.get_observation()[0].status
    assert status is not None
    assert status.linear > 0
    assert (reason, False) in [(c.reason, c.began) for c in fleet.take_changes()]


def test_an_emergency_stops_all_at_once(fleet: RobotFleet) -> None:
    """One call stops every robot whatever is driven, until released."""
    drive(fleet, 0.5, 0, 1)
    fleet.emergency_stop()
    drive(fleet, STOP_BOUND_S + COASTING_S, 0, 1)
    assert not moves(fleet, 0)
    assert not moves(fleet, 1)
    assert {(c.robot, c.reason) for c in fleet.take_changes()} >= {
        (robot, StopReason.EMERGENCY) for robot in (0, 1)
    }
    fleet.release()
    wait_until(lambda: not any(fleet.reasons()))
    drive(fleet, 0.5, 0, 1)
    assert moves(fleet, 0) or moves(fleet, 1)


def test_a_killed_twin_is_told_and_survived(twin: TwinProcess, fleet: RobotFleet) -> None:
    """Everything is lost at once: each robot is named, and no call fails or waits."""
    drive(fleet, 0.3, 0, 1)
    began = time.monotonic()
    twin.process.kill()
    wait_until(lambda: all(StopReason.LINK_LOST in reasons for reasons in fleet.reasons()))
    assert time.monotonic() - began < BOUNDS.link + SLACK_S + 0.1
    drive(fleet, 0.2, 0, 1)
    lost = {(c.robot, c.reason) for c in fleet.take_changes() if c.began}
    assert {(robot, StopReason.LINK_LOST) for robot in (0, 1)} <= lost
    assert {(robot, StopReason.POSE_LOST) for robot in (0, 1)} <= lost


def test_robots_come_back_with_a_new_twin(tmp_path: Path) -> None:
    """A twin that is started again at the same place is found again, without a new session."""
    keys = twin_keys(tmp_path / "keys", 1)
    first = TwinProcess(keys, 1)
    fleet = first.fleet(BOUNDS)
    try:
        fleet.connect(20.0)
        port = int(first.where["robots"][0]["address"].rsplit(":", 1)[1])
        # Its own ports follow one another only when asked for: so the second uses the first's.
        first.kill()
        wait_until(lambda: StopReason.LINK_LOST in fleet.reasons()[0])
        second = TwinProcess(keys, 1, port=port)
        try:
            wait_until(lambda: StopReason.LINK_LOST not in fleet.reasons()[0], 15.0)
        finally:
            second.kill()
    finally:
        fleet.disconnect()


def test_a_study_does_not_begin_until_all_is_live(twin: TwinProcess) -> None:
    """A camera that is dead and a robot that is not seen are named, and nothing is left open."""
    twin.tell("camera_dead 1 on")
    twin.tell("pose_lost 2 on")
    fleet = twin.fleet(BOUNDS)
    with pytest.raises(StudyError, match=r"robot1: the camera.*robot2: motion capture"):
        fleet.connect(3.0)
    assert not any(client.is_connected for client in fleet.clients)
