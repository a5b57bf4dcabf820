"""Maps of rooms as data: dynamics, drawing and heat-map grid all come from one `Layout`."""

from __future__ import annotations

import dataclasses
from itertools import product
from typing import Literal

from study.errors import UnknownNameError
from study.events.scene import DiscMark, RectangleMark, Role, Scene
from study.events.task_description import MapGrid

WALL_THICKNESS = 0.2
"""How thick a wall is drawn, metres. To the dynamics a wall is a line."""


@dataclasses.dataclass(frozen=True, slots=True)
class Rectangle:
    """An axis-aligned rectangle, edges included, metres."""

    left: float
    bottom: float
    right: float
    top: float

    @property
    def width(self) -> float:
        """Extent in x."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """Extent in y."""
        return self.top - self.bottom

    def inset(self, margin: float) -> Rectangle:
        """Return the rectangle with every edge moved inwards by ``margin``."""
        return Rectangle(
            self.left + margin, self.bottom + margin, self.right - margin, self.top - margin
        )

    def overlaps(self, other: Rectangle) -> bool:
        """Say whether the two share an area, not just an edge."""
        return (
            min(self.right, other.right) > max(self.left, other.left)
            and min(self.top, other.top) > max(self.bottom, other.bottom)
        )  # fmt: skip

    def encloses(self, other: Rectangle) -> bool:
        """Say whether ``other`` lies within this rectangle."""
        return (
            self.left <= other.left
            and self.bottom <= other.bottom
            and self.right >= other.right
            and self.top >= other.top
        )

    def mark(self, role: Role) -> RectangleMark:
        """Return the rectangle as a drawing primitive."""
        return RectangleMark(
            role, *(round(value, 9) for value in (self.left, self.bottom, self.width, self.height))
        )


@dataclasses.dataclass(frozen=True, slots=True)
class Disc:
    """A place of a certain radius, metres."""

    x: float
    y: float
    radius: float

    def mark(self, role: Role) -> DiscMark:
        """Return the disc as a drawing primitive."""
        return DiscMark(role, self.x, self.y, self.radius)


@dataclasses.dataclass(frozen=True, slots=True)
class Door:
    """A gap in the wall that two rooms share.

    Attributes:
        rooms: indices of the two rooms.
        wall: "vertical" (the gap lies at x = ``position``) or "horizontal" (at y).
        position: where the wall is, metres.
        low, high: ends of the gap along the wall, metres.
    """

    rooms: tuple[int, int]
    wall: Literal["vertical", "horizontal"]
    position: float
    low: float
    high: float

    def passage(self, robot_radius: float) -> Rectangle:
        """Return where a robot's centre can be while it goes through."""
        low, high = self.low + robot_radius, self.high - robot_radius
        near, far = self.position - robot_radius, self.position + robot_radius
        if self.wall == "vertical":
            return Rectangle(near, low, far, high)
        return Rectangle(low, near, high, far)


@dataclasses.dataclass(frozen=True, slots=True)
class Layout:
    """A map: convex rooms that doors join to a tree, and what stands in them.

    Attributes:
        width, height: extent, metres; the origin is at the bottom left.
        rooms: the floor.
        doors: gaps in the walls between rooms; rooms and doors form a tree.
        hazards: floor that costs health.
        packs: where health is gained; they are never used up.
        start: robots start in its free part.
        start_mark: where the start is drawn.
        goal: where an episode ends well.
        robot_radius: robots keep this distance from walls, metres.

    Raises:
        ValueError: a door's gap is not in a wall that its rooms share or is too narrow, or
            the rooms and doors are no tree.
    """

    width: float
    height: float
    rooms: tuple[Rectangle, ...]
    doors: tuple[Door, ...]
    hazards: tuple[Rectangle, ...]
    packs: tuple[Disc, ...]
    start: Rectangle
    start_mark: Disc
    goal: Disc
    robot_radius: float

    def __post_init__(self) -> None:
        for door in self.doors:
            first, second = (self.rooms[room] for room in door.rooms)
            if door.high - door.low <= 2 * self.robot_radius:
                raise ValueError(f"no robot fits through {door}")
            if not _in_shared_wall(door, first, second):
                raise ValueError(f"{door} is not in a wall that its rooms share")
        reached = {0}
        for _ in self.doors:
            reached |= {
                room for door in self.doors if reached & {*door.rooms} for room in door.rooms
            }
        if len(reached) != len(self.rooms) or len(self.doors) != len(self.rooms) - 1:
            raise ValueError("rooms and doors form no tree")

    def legal_areas(self) -> tuple[Rectangle, ...]:
        """Return the rectangles whose union is where a robot's centre can be."""
        rooms = (room.inset(self.robot_radius) for room in self.rooms)
        return (*rooms, *(door.passage(self.robot_radius) for door in self.doors))

    def walls(self) -> tuple[Rectangle, ...]:
        """Return the rooms' outlines less the doors, as thin rectangles within the map."""
        half = WALL_THICKNESS / 2
        walls = []
        for wall, extent in (("vertical", self.width), ("horizontal", self.height)):
            edges = [edge for room in self.rooms for edge in _edges(room, wall)]
            for position in sorted({edge[0] for edge in edges}):
                gaps = [
                    (door.low, door.high)
                    for door in self.doors
                    if (door.wall, door.position) == (wall, position)
                ]
                spans = [(low, high) for at, low, high in edges if at == position]
                middle = min(max(position, half), extent - half)
                for low, high in _subtract(_merge(spans), gaps):
                    walls.append(
                        Rectangle(middle - half, low, middle + half, high)
                        if wall == "vertical"
                        else Rectangle(low, middle - half, high, middle + half)
                    )
        return tuple(walls)

    def plate(self) -> Rectangle | None:
        """Return the largest rectangle that holds no room, or None if there is none."""
        xs = sorted({0.0, self.width, *(x for room in self.rooms for x in (room.left, room.right))})
        ys = sorted(
            {0.0, self.height, *(y for room in self.rooms for y in (room.bottom, room.top))}
        )
        empty = [
            area
            for left, right in product(xs, xs)
            for bottom, top in product(ys, ys)
            if left < right and bottom < top
            for area in [Rectangle(left, bottom, right, top)]
            if not any(area.overlaps(room) for room in self.rooms)
        ]
        return max(empty, key=lambda area: area.width * area.height, default=None)

    def scene(self) -> Scene:
        """Return the map as drawing primitives."""
        plate = self.plate()
        return Scene(
            width=self.width,
            height=self.height,
            rectangles=(
                *(room.mark("room") for room in self.rooms),
                *(hazard.mark("hazard") for hazard in self.hazards),
                *(wall.mark("wall") for wall in self.walls()),
            ),
            discs=(
                *(pack.mark("health_pack") for pack in self.packs),
                self.goal.mark("goal"),
                self.start_mark.mark("start"),
            ),
            plate=None if plate is None else (plate.left, plate.bottom, plate.width, plate.height),
            robot_radius=self.robot_radius,
        )

    def map_grid(
        self, cell: float, headings: tuple[float, ...], healths: tuple[float, ...]
    ) -> MapGrid:
        """Return the heat-map grid; a cell is free if a robot can be somewhere in it.

        Args:
            cell: side of a cell, metres; divides width and height.
            headings: headings evaluated, radians.
            healths: health levels evaluated, points.
        """
        columns, rows = round(self.width / cell), round(self.height / cell)
        areas = self.legal_areas()

        def is_free(row: int, column: int) -> bool:
            x, y = column * cell, row * cell
            return any(area.overlaps(Rectangle(x, y, x + cell, y + cell)) for area in areas)

        return MapGrid(
            xs=tuple((column + 0.5) * cell for column in range(columns)),
            ys=tuple((row + 0.5) * cell for row in range(rows)),
            headings=headings,
            healths=healths,
            free=tuple(
                "".join("01"[is_free(row, column)] for column in range(columns))
                for row in range(rows)
            ),
        )


def _edges(room: Rectangle, wall: str) -> list[tuple[float, float, float]]:
    """Return the room's two edges along ``wall`` as (position, low, high)."""
    if wall == "vertical":
        return [(x, room.bottom, room.top) for x in (room.left, room.right)]
    return [(y, room.left, room.right) for y in (room.bottom, room.top)]


def _in_shared_wall(door: Door, first: Rectangle, second: Rectangle) -> bool:
    def has(room: Rectangle) -> bool:
        return any(
            at == door.position and low <= door.low and door.high <= high
            for at, low, high in _edges(room, door.wall)
        )

    return has(first) and has(second)


def _merge(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Join spans that touch or overlap."""
    merged: list[tuple[float, float]] = []
    for low, high in sorted(spans):
        if merged and low <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return merged


def _subtract(
    spans: list[tuple[float, float]], gaps: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Cut gaps out of spans."""
    for gap_low, gap_high in gaps:
        spans = [
            part
            for low, high in spans
            for part in ((low, min(high, gap_low)), (max(low, gap_high), high))
            if part[0] < part[1]
        ]
    return spans


LAYOUTS = {
    "three_rooms": Layout(
        width=20.0,
        height=15.0,
        rooms=(
            Rectangle(0.0, 0.0, 9.4, 7.0),
            Rectangle(9.4, 0.0, 20.0, 7.0),
            Rectangle(9.4, 7.0, 20.0, 15.0),
        ),
        doors=(
            Door((0, 1), "vertical", 9.4, 3.6, 6.2),
            Door((1, 2), "horizontal", 7.0, 16.1, 19.0),
        ),
        hazards=(
            Rectangle(3.6, 2.0, 6.6, 4.7),
            Rectangle(12.1, 2.3, 15.3, 7.0),
            Rectangle(13.1, 9.9, 15.8, 15.0),
        ),
        packs=(Disc(1.6, 5.4, 0.6), Disc(18.2, 1.5, 0.6), Disc(18.2, 13.4, 0.6)),
        start=Rectangle(0.0, 0.0, 9.4, 7.0),
        start_mark=Disc(1.6, 1.4, 0.8),
        goal=Disc(11.3, 12.7, 1.0),
        robot_radius=0.35,
    ),
}
"""The maps by the name that protocols use."""


def named_layout(name: str) -> Layout:
    """Return the layout of that name.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    if name not in LAYOUTS:
        raise UnknownNameError("layout", name, list(LAYOUTS))
    return LAYOUTS[name]
