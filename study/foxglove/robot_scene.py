"""A fleet as Foxglove's primitives: made once for its size, then only moved and coloured."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import numpy.typing as npt
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from study.events.codes import ActionSource, Outcome
from study.events.task_description import TaskDescription
from study.foxglove.map_scene import FRAME, WALL_HEIGHT, colour

OPERATED_FRAME = "operated"
"""Frame of the operated robot: the 3D panel can follow it."""

_AUTONOMOUS = (0x3B, 0x48, 0x55)
_OPERATED = (0x00, 0x72, 0xB2)
_INACTIVE = (0xA9, 0xB4, 0xBF)
_ENDED = {
    Outcome.GOAL: (0x00, 0x9E, 0x73),
    Outcome.LOST: (0xD5, 0x5E, 0x00),
    Outcome.TIME_UP: _INACTIVE,
}
_HEIGHT = 0.2
_CLEAR = (0x17, 0x21, 0x2B)


@dataclasses.dataclass(frozen=True, slots=True)
class _Handles:
    """The parts of one robot's entity that change. Messages, so that setting them is enough."""

    stamp: Any
    places: tuple[Any, ...]
    turn: Any
    body: Any


class RobotScene:
    """Draws a fleet of n robots as bodies with a nose and a number.

    Args:
        task: says where position and heading are in the state, and the robot's radius.
        robots: n.

    Attributes:
        robots: n.

    Raises:
        ValueError: the task has no position.
    """

    def __init__(self, task: TaskDescription, robots: int) -> None:
        if not has_position(task):
            raise ValueError(f"the task {task.name} has no position")
        self.robots = robots
        self._task = task
        self._update = SceneUpdate()
        self._handles = [self._add(number) for number in range(robots)]
        self._colours: list[tuple[int, int, int] | None] = [None] * robots
        self._poses = PosesInFrame(frame_id=FRAME)
        self._pose_handles = [self._poses.poses.add() for _ in range(robots)]

    def scene(
        self,
        log_time_ns: int,
        states: npt.NDArray[np.float32],
        outcomes: npt.NDArray[np.int32],
        action_sources: npt.NDArray[np.int32],
        operated: int,
    ) -> SceneUpdate:
        """Return the fleet; the message is reused by the next call.

        Args:
            log_time_ns: nanoseconds since 1970, UTC.
            states: [n, d].
            outcomes: codes.Outcome, [n].
            action_sources: codes.ActionSource, [n].
            operated: index of the operated robot; -1 if none.
        """
        rows = zip(
            self._handles,
            *self._planar(states),
            outcomes.tolist(),
            action_sources.tolist(),
            strict=True,
        )
        seconds, nanos = divmod(log_time_ns, 1_000_000_000)
        for index, (handles, x, y, heading, outcome, source) in enumerate(rows):
            handles.stamp.seconds, handles.stamp.nanos = seconds, nanos
            for place in handles.places:
                place.x, place.y = x, y
            handles.turn.z, handles.turn.w = math.sin(heading / 2), math.cos(heading / 2)
            shown = _ENDED.get(outcome)
            if shown is None:
                shown = _INACTIVE if source == ActionSource.INACTIVE else _AUTONOMOUS
                shown = _OPERATED if index == operated else shown
            if shown != self._colours[index]:
                self._colours[index] = shown
                handles.body.CopyFrom(colour(shown))
        return self._update

    def poses(self, log_time_ns: int, states: npt.NDArray[np.float32]) -> PosesInFrame:
        """Return the fleet's poses, [n, d] states; the message is reused by the next call."""
        self._poses.timestamp.FromNanoseconds(log_time_ns)
        for pose, x, y, heading in zip(self._pose_handles, *self._planar(states), strict=True):
            pose.position.x, pose.position.y = x, y
            pose.orientation.z, pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        return self._poses

    def transforms(
        self, log_time_ns: int, states: npt.NDArray[np.float32], operated: int
    ) -> FrameTransforms:
        """Return where the operated robot is; empty if there is none."""
        found = FrameTransforms()
        if operated < 0:
            return found
        xs, ys, headings = self._planar(states[operated : operated + 1])
        transform = found.transforms.add(parent_frame_id=FRAME, child_frame_id=OPERATED_FRAME)
        transform.timestamp.FromNanoseconds(log_time_ns)
        transform.translation.x, transform.translation.y = xs[0], ys[0]
        transform.rotation.z = math.sin(headings[0] / 2)
        transform.rotation.w = math.cos(headings[0] / 2)
        return found

    def _planar(
        self, states: npt.NDArray[np.float32]
    ) -> tuple[list[float], list[float], list[float]]:
        task = self._task
        turned = task.heading_field >= 0
        headings = states[:, task.heading_field] if turned else np.zeros(len(states))
        return states[:, task.x_field].tolist(), states[:, task.y_field].tolist(), headings.tolist()

    def _add(self, index: int) -> _Handles:
        radius = self._task.scene.robot_radius
        entity = self._update.entities.add(id=f"robot_{index + 1}", frame_id=FRAME)
        body = entity.cylinders.add(bottom_scale=1.0, top_scale=1.0)
        body.size.x = body.size.y = 2 * radius
        body.size.z = _HEIGHT
        body.pose.position.z = _HEIGHT / 2
        body.pose.orientation.w = 1.0
        nose = entity.arrows.add(
            shaft_length=1.1 * radius,
            shaft_diameter=0.35 * radius,
            head_length=0.7 * radius,
            head_diameter=0.9 * radius,
            color=colour(_CLEAR),
        )
        nose.pose.position.z = _HEIGHT
        label = entity.texts.add(
            text=str(index + 1), billboard=True, font_size=1.6 * radius, color=colour(_CLEAR)
        )
        label.pose.position.z = WALL_HEIGHT + radius
        label.pose.orientation.w = 1.0
        places = (body.pose.position, nose.pose.position, label.pose.position)
        return _Handles(entity.timestamp, places, nose.pose.orientation, body.color)


def has_position(task: TaskDescription) -> bool:
    """Return whether a task's states say where a robot is."""
    return task.x_field >= 0 and task.y_field >= 0


def no_robots(log_time_ns: int) -> SceneUpdate:
    """Return the message that takes every robot away: they are of a fleet run that is over."""
    update = SceneUpdate()
    update.deletions.add(type=SceneEntityDeletion.ALL).timestamp.FromNanoseconds(log_time_ns)
    return update
