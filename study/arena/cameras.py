"""What the robots' front cameras see: drawn by MuJoCo where EGL works, else a map from above."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from study.arena.course import ROBOT_RADIUS, Course
from study.arena.model import FRAME_HEIGHT, FRAME_WIDTH
from study.arena.physics import ArenaPhysics, load_mujoco

Picture = npt.NDArray[np.uint8]

_FLOOR, _WALL, _BUCKET, _OTHER, _OWN = (
    (204, 204, 199),
    (115, 120, 128),
    (242, 191, 38),
    (148, 60, 50),
    (41, 120, 181),
)


class Cameras(Protocol):
    """Takes a picture of the world as it is now."""

    def picture(self, robot: int) -> Picture:
        """Return one robot's frame, uint8 [`FRAME_HEIGHT`, `FRAME_WIDTH`, 3]."""
        ...

    def close(self) -> None:
        """Free what drawing holds. Calling it twice is harmless."""
        ...


def open_cameras(physics: ArenaPhysics) -> Cameras:
    """Return front cameras; where there is no EGL, views from above."""
    try:
        return FrontCameras(physics)
    # EGL fails in many ways: no library, no device, no context, each with an error of its own.
    except Exception:
        return ViewFromAbove(physics)


class FrontCameras:
    """Pictures drawn by MuJoCo; for the thread that made it alone, as OpenGL has it.

    Args:
        physics: the world.

    Raises:
        Exception: of many kinds, if EGL does not work here.
    """

    def __init__(self, physics: ArenaPhysics) -> None:
        mujoco: Any = load_mujoco()
        self._physics = physics
        self._renderer = mujoco.Renderer(physics.model, FRAME_HEIGHT, FRAME_WIDTH)

    def picture(self, robot: int) -> Picture:
        """Return one robot's frame, uint8 [`FRAME_HEIGHT`, `FRAME_WIDTH`, 3]."""
        self._renderer.update_scene(self._physics.data, camera=f"robot{robot}_front")
        picture: Picture = self._renderer.render()
        return picture

    def close(self) -> None:
        """Free the context."""
        self._renderer.close()


class ViewFromAbove:
    """The whole arena from above, the robot itself in blue, its nose a dot.

    Args:
        physics: the world.
    """

    def __init__(self, physics: ArenaPhysics) -> None:
        self._physics = physics
        course = physics.course
        scale = max(course.width / FRAME_WIDTH, course.height / FRAME_HEIGHT)
        columns, rows = np.arange(FRAME_WIDTH), np.arange(FRAME_HEIGHT)[::-1]
        self._x = ((columns + 0.5) * scale)[None, :]
        self._y = ((rows + 0.5) * scale)[:, None]
        self._empty = self._drawn_empty(course)

    def _drawn_empty(self, course: Course) -> Picture:
        picture = np.full((FRAME_HEIGHT, FRAME_WIDTH, 3), _FLOOR, np.uint8)
        picture[(self._x > course.width) | (self._y > course.height)] = _WALL
        for bucket in course.buckets:
            self._disc(picture, bucket.x, bucket.y, bucket.radius, _BUCKET)
        return picture

    def _disc(
        self, picture: Picture, x: float, y: float, radius: float, colour: tuple[int, int, int]
    ) -> None:
        picture[(self._x - x) ** 2 + (self._y - y) ** 2 <= radius**2] = colour

    def picture(self, robot: int) -> Picture:
        """Return one robot's frame, uint8 [`FRAME_HEIGHT`, `FRAME_WIDTH`, 3]."""
        picture = self._empty.copy()
        for number, (x, y, heading) in enumerate(self._physics.poses()):
            self._disc(picture, x, y, ROBOT_RADIUS, _OWN if number == robot else _OTHER)
            nose = 0.6 * ROBOT_RADIUS
            nose_x, nose_y = x + nose * math.cos(heading), y + nose * math.sin(heading)
            self._disc(picture, nose_x, nose_y, 0.03, (255, 255, 255))
        return picture

    def close(self) -> None:
        """Do nothing: it holds memory only."""
