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

_Canvas = npt.NDArray[np.float64]
_Colour = tuple[int, int, int]

_FLOOR, _WALL, _BUCKET, _OTHER, _OWN, _BEAKS, _LINE = (
    (226, 226, 221),
    (115, 120, 128),
    (242, 191, 38),
    (148, 60, 50),
    (41, 120, 181),
    (30, 33, 38),
    (140, 145, 152),
)
_BEAK = 1.9
"""How far it reaches from a robot's middle, robot radii: a robot is a few pixels wide."""


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
    """The whole arena from above, the robot itself in blue; a beak shows where each is headed.

    Args:
        physics: the world.
    """

    def __init__(self, physics: ArenaPhysics) -> None:
        self._physics = physics
        course = physics.course
        self._scale = max(course.width / FRAME_WIDTH, course.height / FRAME_HEIGHT)
        columns, rows = np.arange(FRAME_WIDTH), np.arange(FRAME_HEIGHT)[::-1]
        self._x = ((columns + 0.5) * self._scale)[None, :]
        self._y = ((rows + 0.5) * self._scale)[:, None]
        self._empty = self._drawn_empty(course)

    def picture(self, robot: int) -> Picture:
        """Return one robot's frame, uint8 [`FRAME_HEIGHT`, `FRAME_WIDTH`, 3]."""
        picture = self._empty.copy()
        poses = list(enumerate(self._physics.poses()))
        # The robot itself last: where two touch, it is the one to be seen.
        for number, (x, y, heading) in sorted(poses, key=lambda each: each[0] == robot):
            reach = _BEAK * ROBOT_RADIUS
            tip = (x + reach * math.cos(heading), y + reach * math.sin(heading))
            self._paint(picture, self._from_line((x, y), tip) - 0.3 * ROBOT_RADIUS, _BEAKS)
            self._disc(picture, x, y, ROBOT_RADIUS, _OWN if number == robot else _OTHER)
        return picture.astype(np.uint8)

    def close(self) -> None:
        """Do nothing: it holds memory only."""

    def _drawn_empty(self, course: Course) -> _Canvas:
        picture = np.full((FRAME_HEIGHT, FRAME_WIDTH, 3), _FLOOR, np.float64)
        beyond = np.maximum(self._x - course.width, self._y - course.height)
        self._paint(picture, -beyond, _WALL)
        finish = course.gates[-1]
        ends = (finish.inner_x, finish.inner_y), (finish.outer_x, finish.outer_y)
        self._paint(picture, self._from_line(*ends) - 0.5 * self._scale, _LINE)
        for bucket in course.buckets:
            self._disc(picture, bucket.x, bucket.y, bucket.radius, _BUCKET)
        return picture

    def _from_line(self, start: tuple[float, float], end: tuple[float, float]) -> _Canvas:
        """Return how far each pixel is from a line, metres."""
        along = np.subtract(end, start)
        x, y = self._x - start[0], self._y - start[1]
        share = np.clip((x * along[0] + y * along[1]) / (along @ along), 0, 1)
        distance: _Canvas = np.hypot(x - share * along[0], y - share * along[1])
        return distance

    def _disc(self, picture: _Canvas, x: float, y: float, radius: float, colour: _Colour) -> None:
        self._paint(picture, np.hypot(self._x - x, self._y - y) - radius, colour)

    def _paint(self, picture: _Canvas, distance: _Canvas, colour: _Colour) -> None:
        """Paint a shape with a smooth edge, given how far outside of it each pixel is, metres."""
        cover = np.clip(0.5 - distance / self._scale, 0, 1)[..., None]
        picture += cover * (np.array(colour) - picture)
