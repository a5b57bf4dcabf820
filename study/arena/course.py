"""The arena that JetBots share: walls, buckets to drive round, gates, where robots start.

One definition gives the physics model, the map on the screen and the laps. Plain numbers only:
metres, x to the right, y upwards, origin at bottom left, headings in radians counterclockwise.
"""

from __future__ import annotations

import dataclasses
import math

from study.events.scene import DiscMark, GateMark, RectangleMark, Scene
from study.events.task_description import MapGrid

ROBOT_RADIUS = 0.10
"""Of the disc that holds a JetBot's chassis and wheels, metres."""

MOST_ROBOTS = 12
"""As many fit into the start region with room to spare."""


@dataclasses.dataclass(frozen=True, slots=True)
class Bucket:
    """A round obstacle, metres."""

    x: float
    y: float
    radius: float


@dataclasses.dataclass(frozen=True, slots=True)
class Gate:
    """A line across the course, from the buckets (inner) to the wall (outer), metres.

    Who passes it counterclockwise round the buckets passes it forwards.
    """

    inner_x: float
    inner_y: float
    outer_x: float
    outer_y: float


@dataclasses.dataclass(frozen=True, slots=True)
class StartRegion:
    """Where episodes start: a rectangle, and the heading along the course there."""

    x: float
    y: float
    width: float
    height: float
    heading: float


@dataclasses.dataclass(frozen=True, slots=True)
class Course:
    """An arena with a course round its buckets.

    Attributes:
        width, height: inner size, metres; walls stand around it.
        buckets: obstacles.
        gates: in the order of a lap; the last one is the finish line. A way round one bucket
            alone passes not all of them.
        start: just behind the finish line.
    """

    width: float
    height: float
    buckets: tuple[Bucket, ...]
    gates: tuple[Gate, ...]
    start: StartRegion

    def scene(self) -> Scene:
        """Return the map as drawing primitives."""
        start = self.start
        return Scene(
            width=self.width,
            height=self.height,
            rectangles=(RectangleMark("room", 0.0, 0.0, self.width, self.height),),
            discs=(
                *(DiscMark("wall", each.x, each.y, each.radius) for each in self.buckets),
                DiscMark(
                    "start",
                    start.x + start.width / 2,
                    start.y + start.height / 2,
                    min(start.width, start.height) / 2,
                ),
            ),
            plate=None,
            robot_radius=ROBOT_RADIUS,
            gates=tuple(
                GateMark(gate.inner_x, gate.inner_y, gate.outer_x, gate.outer_y)
                for gate in self.gates
            ),
        )

    def map_grid(self, cell: float, headings: tuple[float, ...]) -> MapGrid:
        """Return where a scorer is evaluated: the arena but for where buckets keep robots out.

        Args:
            cell: side of a cell, metres; divides width and height.
            headings: headings evaluated, radians.
        """
        columns, rows = round(self.width / cell), round(self.height / cell)
        xs = tuple((column + 0.5) * cell for column in range(columns))
        ys = tuple((row + 0.5) * cell for row in range(rows))

        def is_free(x: float, y: float) -> bool:
            inside = (
                x + cell / 2 > ROBOT_RADIUS
                and x - cell / 2 < self.width - ROBOT_RADIUS
                and y + cell / 2 > ROBOT_RADIUS
                and y - cell / 2 < self.height - ROBOT_RADIUS
            )
            return inside and all(
                math.hypot(x - bucket.x, y - bucket.y) + cell / 2 > bucket.radius + ROBOT_RADIUS
                for bucket in self.buckets
            )

        return MapGrid(
            xs=xs,
            ys=ys,
            headings=headings,
            healths=(0.0,),
            free=tuple("".join("01"[is_free(x, y)] for x in xs) for y in ys),
        )


TWO_BUCKETS = Course(
    width=4.0,
    height=3.0,
    buckets=(Bucket(1.3, 1.5, 0.15), Bucket(2.7, 1.5, 0.15)),
    gates=(
        Gate(2.7, 1.5, 4.0, 1.5),
        Gate(2.0, 1.5, 2.0, 3.0),
        Gate(1.3, 1.5, 0.0, 1.5),
        Gate(2.0, 1.5, 2.0, 0.0),
    ),
    start=StartRegion(2.15, 0.2, 1.5, 1.0, 0.0),
)
"""An oval round two buckets, with a gap between them through which no lap leads."""
