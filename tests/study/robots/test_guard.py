"""What stops a robot, decided from plain values."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.robots.client import Observation
from study.robots.link import RobotState, Status
from study.robots.poses import Pose
from study.robots.safety import Bounds, Guard, StopReason, reasons_to_stop

BOUNDS = Bounds()
STATUS = Status(1, 1, 1, 1, 1, 1, 0, 0.0, 0.0, 0.8, RobotState.OBEYING)
WELL = Observation(status=STATUS, status_age=0.02, frame=None, frame_age=0.05, round_trip=0.01)
POSE = Pose(1.0, 1.0, 0.0, seen_at=9.95)


def test_a_robot_that_is_well_may_drive() -> None:
    """Nothing speaks against it."""
    assert reasons_to_stop(WELL, POSE, 10.0, BOUNDS) == frozenset()


@pytest.mark.parametrize(
    ("seen", "pose", "reason"),
    [
        ({"status_age": 0.3}, POSE, StopReason.LINK_LOST),
        ({"round_trip": 0.3}, POSE, StopReason.LINK_SLOW),
        ({"frame_age": 0.5}, POSE, StopReason.CAMERA_STALE),
        ({}, None, StopReason.POSE_LOST),
        ({}, Pose(1.0, 1.0, 0.0, seen_at=9.8), StopReason.POSE_LOST),
        ({"status": dataclasses.replace(STATUS, battery=0.1)}, POSE, StopReason.BATTERY_FLAT),
        ({"status": dataclasses.replace(STATUS, state=3)}, POSE, StopReason.EMERGENCY),
    ],
)
def test_each_fault_is_named(
    seen: dict[str, object], pose: Pose | None, reason: StopReason
) -> None:
    """One thing that is not well gives one reason, the right one."""
    observation = dataclasses.replace(WELL, **seen)  # type: ignore[arg-type]
    assert reasons_to_stop(observation, pose, 10.0, BOUNDS) == {reason}


def test_nothing_known_is_all_that_can_be_lost() -> None:
    """Before anything has come there is no robot to drive."""
    unknown = Observation(None, float("inf"), None, float("inf"), float("inf"))
    found = reasons_to_stop(unknown, None, 0.0, BOUNDS)
    assert found == {StopReason.LINK_LOST, StopReason.POSE_LOST, StopReason.CAMERA_STALE}


@given(st.lists(st.tuples(st.floats(0.001, 0.3), st.booleans(), st.booleans()), max_size=60))
def test_changes_add_up_to_what_holds(looks: list[tuple[float, bool, bool]]) -> None:
    """A reason holds at once, and until it has been away long enough; each change is told once."""
    guard, now, told = Guard(2, BOUNDS), 0.0, set[StopReason]()
    last: dict[StopReason, float] = {}
    for gap, pose, camera in looks:
        now += gap
        found = frozenset(
            reason
            for reason, there in ((StopReason.POSE_LOST, pose), (StopReason.CAMERA_STALE, camera))
            if there
        )
        last |= dict.fromkeys(found, now)
        for change in guard.look(found, now):
            assert (change.robot, change.at) == (2, now)
            assert change.began == (change.reason not in told)
            told ^= {change.reason}
        assert told == guard.reasons
        assert guard.reasons >= found
        assert guard.reasons == {r for r, at in last.items() if now - at < BOUNDS.settled}


def test_changes_are_sentences() -> None:
    """What the operator reads counts robots from 1."""
    guard = Guard(0, BOUNDS)
    began = guard.look(frozenset({StopReason.POSE_LOST}), 1.0)
    ended = guard.look(frozenset(), 2.0)
    assert began[0].text() == "robot 1 stopped: motion capture does not see the robot"
    assert ended[0].text().endswith("it is well again")
