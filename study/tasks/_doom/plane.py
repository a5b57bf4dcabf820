"""A layout cut into sectors: vertices, lines with a front and a back, kinds of floor.

A room's faces stand half a wall's thickness inside its outline, as walls are drawn, and the
player's half width is the robot's radius less that half thickness. The engine moves squares
along the axes, so that a robot's centre can be exactly in `Layout.legal_areas`.
"""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

from study.layouts import WALL_THICKNESS, Disc, Layout, Rectangle

UNITS = 80
"""Map units a metre: what layouts give in tenths of a metre then lies on whole units."""

GRID = 1024
"""Places are kept to this fraction of a map unit, which float32 metres tell apart."""

_CORNERS = 16
"""Corners of the polygon that a disc is painted as."""

Kind = tuple[str, int]
"""What a sector is, and of which room or number: ("room", 0), ("pack", 2), ..."""

Point = tuple[int, int]
"""A place in 1/`GRID` of a map unit."""


@dataclasses.dataclass(frozen=True, slots=True)
class Line:
    """A line; seen from its start to its end the front is on the right. No back: a wall."""

    start: Point
    end: Point
    front: Kind
    back: Kind | None


def on_grid(metres: float) -> int:
    """Return a length in 1/`GRID` of a map unit."""
    return round(metres * UNITS * GRID)


def player_radius(layout: Layout) -> float:
    """Return the player's half width, map units.

    Raises:
        ValueError: the robot is no wider than a wall.
    """
    radius = layout.robot_radius - WALL_THICKNESS / 2
    if radius <= 0:
        raise ValueError("robots must be wider than walls are thick")
    return on_grid(radius) / GRID


def cut_lines(layout: Layout) -> list[Line]:
    """Return the map's lines, always in the same order.

    Raises:
        ValueError: a disc lies on two kinds of floor, or two discs meet.
    """
    half = WALL_THICKNESS / 2
    rooms = [room.inset(half) for room in layout.rooms]
    doors = [_gap(door.passage(0.0), half, door.wall) for door in layout.doors]
    areas = [*rooms, *doors]
    cuts = [*areas, *layout.hazards]
    xs = sorted({on_grid(x) for area in cuts for x in (area.left, area.right)})
    ys = sorted({on_grid(y) for area in cuts for y in (area.bottom, area.top)})

    def kind(column: int, row: int) -> Kind | None:
        if not (0 <= column < len(xs) - 1 and 0 <= row < len(ys) - 1):
            return None
        x, y = (xs[column] + xs[column + 1]) / 2, (ys[row] + ys[row + 1]) / 2
        for number, area in enumerate(areas):
            if _holds(area, x, y):
                hazard = any(_holds(rectangle, x, y) for rectangle in layout.hazards)
                return ("hazard" if hazard else "room", min(number, len(rooms)))
        return None

    kinds = {
        (column, row): kind(column, row)
        for column in range(-1, len(xs))
        for row in range(-1, len(ys))
    }
    lines = []
    for column in range(len(xs)):
        for row, (low, high) in enumerate(pairwise(ys)):
            up = ((xs[column], low), (xs[column], high))
            lines += _between(*up, kinds[column, row], kinds[column - 1, row])
    for row in range(len(ys)):
        for column, (low, high) in enumerate(pairwise(xs)):
            along = ((low, ys[row]), (high, ys[row]))
            lines += _between(*along, kinds[column, row - 1], kinds[column, row])
    boxes: list[Rectangle] = []
    named = [("goal", layout.goal), ("start", layout.start_mark)]
    for number, (name, disc) in enumerate([*named, *(("pack", pack) for pack in layout.packs)]):
        box = Rectangle(
            disc.x - disc.radius, disc.y - disc.radius, disc.x + disc.radius, disc.y + disc.radius
        )
        below = {
            kinds[column, row]
            for column, (left, right) in enumerate(pairwise(xs))
            for row, (bottom, top) in enumerate(pairwise(ys))
            if _units(left, bottom, right, top).overlaps(box)
        }
        if len(below) != 1 or None in below or any(box.overlaps(other) for other in boxes):
            raise ValueError(f"{disc} must lie on one kind of floor, apart from other discs")
        boxes.append(box)
        lines += _outline(disc, (name, number), below.pop())
    return _joined(lines)


def _gap(passage: Rectangle, half: float, wall: str) -> Rectangle:
    """Return a door's floor: as thick as the wall, and narrower by the wall's rounded ends."""
    if wall == "vertical":
        return Rectangle(
            passage.left - half, passage.bottom + half, passage.right + half, passage.top - half
        )
    return Rectangle(
        passage.left + half, passage.bottom - half, passage.right - half, passage.top + half
    )


def _units(left: int, bottom: int, right: int, top: int) -> Rectangle:
    scale = UNITS * GRID
    return Rectangle(left / scale, bottom / scale, right / scale, top / scale)


def _holds(area: Rectangle, x: float, y: float) -> bool:
    left, bottom, right, top = map(on_grid, (area.left, area.bottom, area.right, area.top))
    return left < x < right and bottom < y < top


def _between(start: Point, end: Point, right: Kind | None, left: Kind | None) -> list[Line]:
    """Return the line between what is on either side of start to end, if they differ."""
    if right == left:
        return []
    if right is None:
        return [Line(end, start, left, None)] if left is not None else []
    return [Line(start, end, right, left)]


def _outline(disc: Disc, inside: Kind, outside: Kind | None) -> list[Line]:
    """Return a polygon around a disc, clockwise, so that its front is inside."""
    x, y, radius = on_grid(disc.x), on_grid(disc.y), on_grid(disc.radius)
    corners = [
        (
            x + round(radius * math.cos(-math.tau * corner / _CORNERS)),
            y + round(radius * math.sin(-math.tau * corner / _CORNERS)),
        )
        for corner in range(_CORNERS)
    ]
    return [Line(*ends, inside, outside) for ends in pairwise([*corners, corners[0]])]


def _joined(lines: list[Line]) -> list[Line]:
    """Join lines that go straight on where no other line begins or ends."""
    ends: dict[Point, int] = {}
    for line in lines:
        for point in (line.start, line.end):
            ends[point] = ends.get(point, 0) + 1
    after = {(line.start, line.front, line.back): line for line in lines}

    def onwards(line: Line) -> Line | None:
        follower = after.get((line.end, line.front, line.back))
        if follower is None or ends[line.end] != 2 or not _straight(line, follower):
            return None
        return follower

    followers = {onwards(line) for line in lines}
    joined = []
    for first in lines:
        if first in followers:
            continue
        last = first
        while (follower := onwards(last)) is not None:
            last = follower
        joined.append(dataclasses.replace(first, end=last.end))
    return joined


def _straight(line: Line, onwards: Line) -> bool:
    (ax, ay), (bx, by), (cx, cy) = line.start, line.end, onwards.end
    return (bx - ax) * (cy - by) == (by - ay) * (cx - bx)
