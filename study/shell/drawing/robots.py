"""A robot's body: a notched dart when driven by the participant, a drop when it drives itself.

The two differ in shape, not in colour alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pygame

from study.shell.drawing import marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.marks import Point
from study.shell.drawing.sprites import Paint

HEADING_STEPS = 180
"""Headings are drawn to the nearest 2 degrees, so that each body is painted once."""
HEADINGS = HEADING_STEPS // 8 + 1
"""So many of them are painted; the others are mirrored and turned."""
DROP_TIP = 1.75
"""Reach of a drop's tip in radii."""
HALO = 2.15
"""Radius of the ring around a driven robot in radii of its body."""
DRIVEN_SCALE = 1.25
"""A driven robot is drawn this much larger."""
SMALLEST_NUMBER = 9
"""Pixels below which the number on a body is left out: the plate has it too."""


def _turned(points: list[Point], angle: float, middle: float, size: float) -> list[Point]:
    """Turn points counter-clockwise as seen on the screen and scale them about a middle."""
    c, s = math.cos(angle), math.sin(angle)
    return [(middle + size * (x * c + y * s), middle + size * (y * c - x * s)) for x, y in points]


def _drop(reach: float) -> list[Point]:
    """Return the outline of a drop of radius 1 whose tip lies at (reach, 0)."""
    start = math.acos(1 / reach)
    extent = 2 * math.pi - 2 * start
    steps = 40
    arc = [start + extent * step / steps for step in range(steps + 1)]
    return [(reach, 0.0), *((math.cos(a), math.sin(a)) for a in arc)]


DROP = _drop(DROP_TIP)
DART: list[Point] = [(1.75, 0.0), (-1.10, 0.98), (-0.52, 0.0), (-1.10, -0.98)]


def heading_step(heading: float) -> int:
    """Return the number of the drawn heading nearest to one in radians."""
    return round(heading / (2 * math.pi) * HEADING_STEPS) % HEADING_STEPS


def _within_an_eighth(step: int) -> tuple[int, bool, int]:
    """Return a heading of the first 45 degrees that a heading is, but for mirroring and turning.

    Painted in all headings robots would fill megabytes, little by little: some headings are first
    seen after an hour. Their shapes are their own mirror images, so that an eighth of them will do.

    Returns:
        The heading to paint, whether its picture is then turned upside down, and by how many
        quarters of a turn, counter-clockwise, it is turned after that.
    """
    quarters, rest = divmod(step, HEADING_STEPS // 4)
    if 2 * rest <= HEADING_STEPS // 4:
        return rest, False, quarters
    return HEADING_STEPS // 4 - rest, True, quarters + 1


def draw_robot(
    canvas: Canvas,
    x: float,
    y: float,
    radius: float,
    heading: float,
    *,
    driven: bool,
    label: str = "",
    over_ring: Callable[[], None] | None = None,
) -> None:
    """Draw a robot.

    Args:
        canvas: to draw on.
        x: middle, pixels.
        y: middle, pixels.
        radius: of the body, pixels.
        heading: radians, counter-clockwise from the right.
        driven: whether the participant drives it.
        label: its number, or empty.
        over_ring: draws what covers the ring of a driven robot and not its body.
    """
    if driven:
        radius *= DRIVEN_SCALE
    painted, mirrored, quarters = _within_an_eighth(heading_step(heading))
    angle = 2 * math.pi * painted / HEADING_STEPS
    rim = max(1.2, radius * 0.12)

    def paint_drop(surface: pygame.Surface, k: float) -> None:
        middle, size = surface.get_rect().centerx, radius * k
        outer = _turned(DROP, angle, middle, size + rim * k)
        pygame.draw.polygon(surface, marks.WHITE, outer)
        pygame.draw.polygon(surface, palette.AUTONOMOUS, _turned(DROP, angle, middle, size))

    def paint_ring(surface: pygame.Surface, k: float) -> None:
        middle, size = surface.get_rect().centerx, radius * k
        halo, line = HALO * size, max(2.0, radius * 0.17) * k
        nose = [(HALO + 0.62, 0.0), (HALO - 0.02, 0.36), (HALO - 0.02, -0.36)]
        pygame.draw.circle(surface, marks.WHITE, (middle, middle), halo + rim * k)
        pygame.draw.circle(surface, palette.BLUE, (middle, middle), halo)
        pygame.draw.circle(surface, marks.WHITE, (middle, middle), halo - line)
        pygame.draw.polygon(surface, palette.BLUE, _turned(nose, angle, middle, size))

    def paint_dart(surface: pygame.Surface, k: float) -> None:
        middle = surface.get_rect().centerx
        turned = _turned(DART, angle, middle, radius * k * 0.98)
        pygame.draw.polygon(surface, palette.BLUE, turned)

    def put(name: str, reach: float, paint: Paint) -> None:
        key = (name, round(radius * 4), painted)
        sprite = canvas.sprite(key, 2 * reach, 2 * reach, paint)
        if mirrored:
            sprite = pygame.transform.flip(sprite, flip_x=False, flip_y=True)
        if quarters:
            sprite = pygame.transform.rotate(sprite, 90 * quarters)
        canvas.put(sprite, x, y)

    if driven:
        put("ring", radius * (HALO + 0.75) + 3, paint_ring)
        if over_ring is not None:
            over_ring()
    put("dart" if driven else "drop", radius * DROP_TIP + 3, paint_dart if driven else paint_drop)
    size = radius * (0.8 if driven else 1.15) * (0.84 if len(label) > 1 else 1.0)
    if label and size >= SMALLEST_NUMBER:
        canvas.write(label, x, y, size, weight="bold", colour=marks.WHITE, align="centre")
