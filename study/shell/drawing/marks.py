"""Marks and pictograms as smooth vector shapes. Places are middles, sizes pixels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import pygame

from study.shell.drawing import palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.palette import Colour

Point = tuple[float, float]
WHITE: Colour = (255, 255, 255)


def _polygon(surface: pygame.Surface, colour: Colour, points: Sequence[Point]) -> None:
    pygame.draw.polygon(surface, colour, [(round(x), round(y)) for x, y in points])


def thick_line(
    surface: pygame.Surface, colour: Colour, points: Sequence[Point], width: float
) -> None:
    """Draw a polyline with round ends and joints."""
    radius = width / 2
    for x, y in points:
        pygame.draw.circle(surface, colour, (x, y), radius)
    for (x0, y0), (x1, y1) in pairwise(points):
        length = math.hypot(x1 - x0, y1 - y0)
        if length == 0:
            continue
        nx, ny = -(y1 - y0) / length * radius, (x1 - x0) / length * radius
        _polygon(
            surface,
            colour,
            [(x0 + nx, y0 + ny), (x1 + nx, y1 + ny), (x1 - nx, y1 - ny), (x0 - nx, y0 - ny)],
        )


def disc(canvas: Canvas, x: float, y: float, radius: float, colour: Colour) -> None:
    """Draw a filled disc."""
    diameter = 2 * radius + 2

    def paint(surface: pygame.Surface, k: float) -> None:
        pygame.draw.circle(surface, colour, surface.get_rect().center, radius * k)

    canvas.put(canvas.sprite(("disc", round(radius * 4), colour), diameter, diameter, paint), x, y)


def ring(
    canvas: Canvas,
    x: float,
    y: float,
    radius: float,
    width: float,
    colour: Colour,
    *,
    fill: Colour | None = None,
    alpha: float = 1.0,
) -> None:
    """Draw a circle line of an outer radius, filled or not."""
    radius = round(radius * 2) / 2
    diameter = 2 * radius + 2

    def paint(surface: pygame.Surface, k: float) -> None:
        middle = surface.get_rect().center
        pygame.draw.circle(surface, colour, middle, radius * k)
        inside = fill if fill is not None else (0, 0, 0, 0)
        pygame.draw.circle(surface, inside, middle, max(0.0, radius - width) * k)

    key = ("ring", radius, round(width * 4), colour, fill)
    canvas.put(canvas.sprite(key, diameter, diameter, paint), x, y, alpha)


def passing_ring(
    canvas: Canvas, x: float, y: float, radius: float, width: float, colour: Colour
) -> None:
    """Draw a circle line of an outer radius that is another in the next picture.

    Large, and of hundreds of sizes: painted where it is, and never kept.
    """
    centre, line = (round(x), round(y)), max(1, round(width))
    pygame.draw.aacircle(canvas.surface, colour, centre, round(radius), line)


def dashed_ring(
    canvas: Canvas,
    x: float,
    y: float,
    radius: float,
    width: float,
    colour: Colour,
    *,
    dashes: int = 12,
    fill: Colour | None = None,
) -> None:
    """Draw a circle of dashes, filled or not."""
    diameter = 2 * radius + 2

    def paint(surface: pygame.Surface, k: float) -> None:
        middle = surface.get_rect().centerx
        if fill is not None:
            pygame.draw.circle(surface, fill, (middle, middle), (radius - width / 2) * k)
        turn = 2 * math.pi / dashes
        for dash in range(dashes):
            _sector(surface, middle, radius * k, width * k, dash * turn, turn * 0.6, colour)

    key = ("dashed", round(radius * 2), round(width * 4), colour, dashes, fill)
    canvas.put(canvas.sprite(key, diameter, diameter, paint), x, y)


def _sector(
    surface: pygame.Surface,
    middle: float,
    radius: float,
    width: float,
    start: float,
    extent: float,
    colour: Colour,
) -> None:
    """Draw a piece of a circle line; angles clockwise from the top, radians."""
    steps = max(2, math.ceil(extent * radius / 6))
    angles = [start + extent * step / steps - math.pi / 2 for step in range(steps + 1)]
    outer = [(middle + radius * math.cos(a), middle + radius * math.sin(a)) for a in angles]
    inside = radius - width
    inner = [(middle + inside * math.cos(a), middle + inside * math.sin(a)) for a in angles]
    _polygon(surface, colour, [*outer, *reversed(inner)])


def draining_ring(
    canvas: Canvas, x: float, y: float, radius: float, width: float, left: float
) -> None:
    """Draw what is left of a dwell: the line shortens clockwise from the top."""
    steps = 120
    step = max(0, min(steps, round(left * steps)))
    diameter = 2 * radius + 2

    def paint(surface: pygame.Surface, k: float) -> None:
        middle = surface.get_rect().centerx
        pygame.draw.circle(surface, WHITE, (middle, middle), radius * k)
        pygame.draw.circle(surface, (0, 0, 0, 0), (middle, middle), (radius - width) * k)
        if step:
            extent = 2 * math.pi * step / steps
            _sector(
                surface, middle, radius * k, width * k, 2 * math.pi - extent, extent, palette.BLUE
            )

    key = ("drain", round(radius * 2), round(width * 4), step)
    canvas.put(canvas.sprite(key, diameter, diameter, paint), x, y)


def health_cross(
    canvas: Canvas, x: float, y: float, size: float, colour: Colour = palette.GREEN
) -> None:
    """Draw a health pack's cross; crisp, since its edges lie on pixels."""
    arm = max(2, round(size / 3))
    length = arm * 3
    left, top = round(x - length / 2), round(y - length / 2)
    canvas.surface.fill(colour, (left + arm, top, arm, length))
    canvas.surface.fill(colour, (left, top + arm, length, arm))


def flag(canvas: Canvas, x: float, y: float, size: float, colour: Colour = palette.INK) -> None:
    """Draw a chequered flag, ``size`` pixels high."""

    def paint(surface: pygame.Surface, k: float) -> None:
        s = size * k
        pole = 0.10 * s
        thick_line(surface, colour, [(pole / 2, pole / 2), (pole / 2, s - pole / 2)], pole)
        left, top, right, bottom = pole / 2, 0.06 * s, 0.80 * s, 0.56 * s
        pygame.draw.rect(surface, colour, (left, top, right - left, bottom - top))
        cells, rows, edge = 3, 2, 0.045 * s
        width = (right - left - 2 * edge) / cells
        height = (bottom - top - 2 * edge) / rows
        for row in range(rows):
            for cell in range(cells):
                if (row + cell) % 2:
                    corner = (left + edge + cell * width, top + edge + row * height)
                    pygame.draw.rect(surface, WHITE, (*corner, width, height))

    canvas.put(canvas.sprite(("flag", round(size), colour), size * 0.82, size, paint), x, y)


def hatch(canvas: Canvas, place: pygame.Rect, pitch: float) -> None:
    """Draw a hazard's ground: slanted lines on a light brown."""
    width, height = place.size
    edge = max(1.0, pitch * 0.11)

    def paint(surface: pygame.Surface, k: float) -> None:
        surface.fill(palette.HATCH_GROUND)
        w, h, step, line = width * k, height * k, pitch * k, pitch * 0.19 * k
        x = -h + step / 2
        while x < w:
            thick_line(surface, palette.HATCH, [(x, h), (x + h, 0)], line)
            x += step
        pygame.draw.rect(surface, palette.HATCH, (0, 0, w, h), round(edge * k))

    key = ("hatch", width, height, round(pitch * 4))
    canvas.put(canvas.sprite(key, width, height, paint), *_middle(place))


def _middle(place: pygame.Rect) -> Point:
    return place.left + place.width / 2, place.top + place.height / 2


def arrow(
    canvas: Canvas, x: float, y: float, size: float, direction: str, colour: Colour, stroke: float
) -> None:
    """Draw an arrow pointing "up", "down", "left" or "right"."""

    def paint(surface: pygame.Surface, k: float) -> None:
        s, w = size * k, stroke * k
        half, head = s / 2 - w / 2, 0.36 * s
        middle = surface.get_rect().centerx
        forward = {"up": (0, -1), "down": (0, 1), "left": (-1, 0), "right": (1, 0)}[direction]
        fx, fy = forward
        tip = (middle + fx * half, middle + fy * half)
        tail = (middle - fx * half, middle - fy * half)
        barbs = [
            (tip[0] - fx * head + side * fy * head, tip[1] - fy * head + side * fx * head)
            for side in (1, -1)
        ]
        thick_line(surface, colour, [tail, tip], w)
        thick_line(surface, colour, [barbs[0], tip, barbs[1]], w)

    key = ("arrow", round(size * 2), direction, colour, round(stroke * 4))
    canvas.put(canvas.sprite(key, size + 2, size + 2, paint), x, y)


def tick(canvas: Canvas, x: float, y: float, size: float, colour: Colour, stroke: float) -> None:
    """Draw a tick."""

    def paint(surface: pygame.Surface, k: float) -> None:
        s = size * k
        points = [(0.14 * s, 0.54 * s), (0.40 * s, 0.78 * s), (0.86 * s, 0.24 * s)]
        thick_line(surface, colour, points, stroke * k)

    key = ("tick", round(size * 2), colour, round(stroke * 4))
    canvas.put(canvas.sprite(key, size, size, paint), x, y)


def saltire(canvas: Canvas, x: float, y: float, size: float, colour: Colour, stroke: float) -> None:
    """Draw an x-shaped cross."""

    def paint(surface: pygame.Surface, k: float) -> None:
        low, high = 0.18 * size * k, 0.82 * size * k
        thick_line(surface, colour, [(low, low), (high, high)], stroke * k)
        thick_line(surface, colour, [(low, high), (high, low)], stroke * k)

    key = ("saltire", round(size * 2), colour, round(stroke * 4))
    canvas.put(canvas.sprite(key, size, size, paint), x, y)


def triangle_down(canvas: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    """Draw a triangle pointing down: something fell."""

    def paint(surface: pygame.Surface, k: float) -> None:
        s = size * k
        _polygon(surface, colour, [(0.05 * s, 0.15 * s), (0.95 * s, 0.15 * s), (s / 2, 0.9 * s)])

    canvas.put(canvas.sprite(("down", round(size * 2), colour), size, size, paint), x, y)


def triangle_right(canvas: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    """Draw a triangle pointing right: something plays."""

    def paint(surface: pygame.Surface, k: float) -> None:
        s = size * k
        _polygon(surface, colour, [(0.15 * s, 0.05 * s), (0.15 * s, 0.95 * s), (0.95 * s, s / 2)])

    canvas.put(canvas.sprite(("right", round(size * 2), colour), size, size, paint), x, y)


def clock(canvas: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    """Draw a clock face."""

    def paint(surface: pygame.Surface, k: float) -> None:
        s, w = size * k, size * k * 0.085
        pygame.draw.circle(surface, colour, (s / 2, s / 2), s / 2)
        pygame.draw.circle(surface, (0, 0, 0, 0), (s / 2, s / 2), s / 2 - w)
        hands = [(s / 2, 0.22 * s), (s / 2, s / 2), (0.68 * s, 0.62 * s)]
        thick_line(surface, colour, hands, w)

    canvas.put(canvas.sprite(("clock", round(size), colour), size, size, paint), x, y)


def burst(canvas: Canvas, x: float, y: float, radius: float, stroke: float) -> None:
    """Draw the jagged star of damage around a robot."""

    def paint(surface: pygame.Surface, k: float) -> None:
        middle, spikes = surface.get_rect().centerx, 14

        def star(outer: float) -> list[Point]:
            points = []
            for corner in range(2 * spikes):
                reach = outer if corner % 2 == 0 else outer * 0.83
                angle = math.pi * corner / spikes
                points.append((middle + reach * math.cos(angle), middle + reach * math.sin(angle)))
            return points

        _polygon(surface, palette.VERMILLION_TEXT, star(radius * k))
        _polygon(surface, palette.VERMILLION_TINT, star((radius - 1.3 * stroke) * k))

    key = ("burst", round(radius * 2), round(stroke * 4))
    canvas.put(canvas.sprite(key, 2 * radius + 2, 2 * radius + 2, paint), x, y)
