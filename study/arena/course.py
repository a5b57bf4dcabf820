"""The arena that JetBots share: walls, buckets to drive round, gates, where robots start.

One definition gives the physics model, the map on the screen and the laps. Plain numbers only:
metres, x to the right, y upwards, origin at bottom left, headings in radians counterclockwise.
"""

from __future__ import annotations

import dataclasses

from study.events.scene import DiscMark, RectangleMark, Scene

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
        """Return the map as drawing primitives; a bucket is drawn as the square around it."""
        rectangles = [RectangleMark("room", 0.0, 0.0, self.width, self.height)]
        rectangles += [
            RectangleMark(
                "wall",
                bucket.x - bucket.radius,
                bucket.y - bucket.radius,
                2 * bucket.radius,
                2 * bucket.radius,
            )
            for bucket in self.buckets
        ]
        start = self.start
        return Scene(
            width=self.width,
            height=self.height,
            rectangles=tuple(rectangles),
            discs=(
                DiscMark(
                    "start",
                    start.x + start.width / 2,
                    start.y + start.height / 2,
                    min(start.width, start.height) / 2,
                ),
            ),
            plate=None,
            robot_radius=ROBOT_RADIUS,
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
