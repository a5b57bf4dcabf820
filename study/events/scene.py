"""A map as drawing primitives in the task's own units: recorded, so figures need no task."""

from __future__ import annotations

import dataclasses
from typing import Literal

Role = Literal["room", "wall", "hazard", "health_pack", "goal", "start"]


@dataclasses.dataclass(frozen=True, slots=True)
class RectangleMark:
    """An axis-aligned rectangle; a wall is a thin one."""

    role: Role
    x: float
    y: float
    width: float
    height: float


@dataclasses.dataclass(frozen=True, slots=True)
class DiscMark:
    """A disc: a goal, a health pack, the middle of the start region; a wall is a round obstacle."""

    role: Role
    x: float
    y: float
    radius: float


@dataclasses.dataclass(frozen=True, slots=True)
class GateMark:
    """A line across a course that is driven round and round, from its inner to its outer end.

    It is passed forwards with the inner end on the left.
    """

    inner_x: float
    inner_y: float
    outer_x: float
    outer_y: float


@dataclasses.dataclass(frozen=True, slots=True)
class Scene:
    """What a map looks like: x to the right, y upwards, origin at bottom left.

    Attributes:
        width: extent in x, metres.
        height: extent in y, metres.
        rectangles: rooms, walls and hazards, in drawing order.
        discs: packs, goal, start.
        plate: the rectangle (x, y, width, height) that holds no room: a tile writes its
            number there. ``None`` where the map fills its bounds.
        robot_radius: metres.
        camera: whether tiles show pictures that the task takes of its robots. The map then gives
            their shape. It may be empty; one that is not is shown where a picture is missing.
        inset: whether the map is drawn small in a corner of each picture.
        gates: to be passed in this order, lap after lap; the last is the finish line. Empty where
            there are no laps.
    """

    width: float
    height: float
    rectangles: tuple[RectangleMark, ...]
    discs: tuple[DiscMark, ...]
    plate: tuple[float, float, float, float] | None
    robot_radius: float
    camera: bool = False
    inset: bool = False
    gates: tuple[GateMark, ...] = ()

    @property
    def pictures_only(self) -> bool:
        """Whether pictures are all there is: no map to draw robots on, or to speak of."""
        return self.camera and not (self.rectangles or self.discs)
