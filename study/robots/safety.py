"""What stops a robot, and why: decided from what is known of it, without clock or socket."""

from __future__ import annotations

import dataclasses
from enum import IntEnum

from study.robots.client import Observation
from study.robots.link import RobotState
from study.robots.poses import Pose


class StopReason(IntEnum):
    """Why a robot stands though it is told to drive; several may hold at once."""

    LINK_LOST = 1
    LINK_SLOW = 2
    POSE_LOST = 3
    CAMERA_STALE = 4
    BATTERY_FLAT = 5
    EMERGENCY = 6


REASON_TEXTS = {
    StopReason.LINK_LOST: "no answer from the robot",
    StopReason.LINK_SLOW: "the link to the robot is too slow",
    StopReason.POSE_LOST: "motion capture does not see the robot",
    StopReason.CAMERA_STALE: "the camera's picture does not change",
    StopReason.BATTERY_FLAT: "the battery is flat",
    StopReason.EMERGENCY: "emergency stop",
}


@dataclasses.dataclass(frozen=True, slots=True)
class Bounds:
    """When something counts as lost, seconds; battery is a part of full.

    The robot stands at most 0.1 s after: the supervisor looks every 20 ms, and a command takes
    its way.
    """

    link: float = 0.25
    round_trip: float = 0.25
    pose: float = 0.15
    camera: float = 0.4
    battery: float = 0.1
    settled: float = 0.5
    """For how long all must have been well before the robot drives again."""


USUAL_BOUNDS = Bounds()


@dataclasses.dataclass(frozen=True, slots=True)
class SafetyChange:
    """A reason to stop a robot began or ended.

    Attributes:
        robot: its number.
        reason: which.
        began: False if it ended.
        at: `time.monotonic`.
    """

    robot: int
    reason: StopReason
    began: bool
    at: float

    def text(self) -> str:
        """Say it in a sentence."""
        what = REASON_TEXTS[self.reason]
        return f"robot {self.robot + 1} {'stopped' if self.began else 'was stopped'}: {what}" + (
            "" if self.began else "; it is well again"
        )


def reasons_to_stop(
    seen: Observation, pose: Pose | None, now: float, bounds: Bounds
) -> frozenset[StopReason]:
    """Return all that speaks against driving a robot now.

    Args:
        seen: of the robot.
        pose: None if it was never seen.
        now: `time.monotonic`.
        bounds: when something counts as lost.
    """
    status = seen.status
    found = set()
    if status is None or seen.status_age > bounds.link:
        found.add(StopReason.LINK_LOST)
    elif seen.round_trip > bounds.round_trip:
        found.add(StopReason.LINK_SLOW)
    if pose is None or now - pose.seen_at > bounds.pose:
        found.add(StopReason.POSE_LOST)
    if seen.frame_age > bounds.camera:
        found.add(StopReason.CAMERA_STALE)
    if status is not None and status.battery <= bounds.battery:
        found.add(StopReason.BATTERY_FLAT)
    if status is not None and status.state == RobotState.EMERGENCY:
        found.add(StopReason.EMERGENCY)
    return frozenset(found)


class Guard:
    """Remembers why one robot stands, and when it may drive again.

    Args:
        robot: its number.
        bounds: when something counts as lost.
    """

    def __init__(self, robot: int, bounds: Bounds) -> None:
        self._robot = robot
        self._bounds = bounds
        self._held: dict[StopReason, float] = {}

    @property
    def reasons(self) -> frozenset[StopReason]:
        """Why it stands; empty if it may drive."""
        return frozenset(self._held)

    def look(self, found: frozenset[StopReason], now: float) -> list[SafetyChange]:
        """Take in what speaks against driving now.

        A reason holds until it has been away for `Bounds.settled`: a robot that is seen and lost
        in turn does not jerk.

        Returns:
            What began or ended.
        """
        changes = [
            SafetyChange(self._robot, reason, began=True, at=now)
            for reason in sorted(found - set(self._held))
        ]
        self._held |= dict.fromkeys(found, now)
        for reason, last in sorted(self._held.items()):
            if reason not in found and now - last >= self._bounds.settled:
                del self._held[reason]
                changes.append(SafetyChange(self._robot, reason, began=False, at=now))
        return changes
