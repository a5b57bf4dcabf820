"""Frames around tiles. They mean control only: solid blue is driven, dashed orange suggested."""

from __future__ import annotations

import pygame

from study.shell.drawing import marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.grid import TilePlace

FRAME = 6
"""Design pixels."""


def frame_rect(canvas: Canvas, place: TilePlace) -> pygame.Rect:
    """Return the rectangle that a tile takes with its frame and bar, pixels."""
    edge = canvas.u(FRAME)
    body = place.body
    top = body.top - max(place.bar, edge)
    return pygame.Rect(body.left - edge, top, body.width + 2 * edge, body.bottom + edge - top)


def driven_frame(canvas: Canvas, place: TilePlace, robot: int) -> None:
    """Draw the blue frame of a driven robot (index from 0), with its bar if it has one."""
    frame = frame_rect(canvas, place)
    body = place.body
    canvas.box(frame, canvas.u(6), palette.BLUE)
    canvas.surface.fill(palette.CARD, body.inflate(2, 2))
    if not place.bar:
        return
    middle = (frame.top + body.top) / 2
    size = canvas.u(28 if place.single else 21)
    title = f"YOU  ·  robot {robot + 1}" if place.single else "YOU"
    left = body.left + canvas.u(20 if place.single else 10)
    canvas.write(title, left, middle, size, weight="bold", colour=palette.CARD)
    arrow = canvas.u(20 if place.single else 16)
    right = body.right - canvas.u(20 if place.single else 12)
    for number, direction in enumerate(("right", "down", "up", "left")):
        x = right - arrow / 2 - number * arrow * 1.38
        marks.arrow(canvas, x, middle, arrow, direction, palette.CARD, max(1.6, arrow * 0.1))


def suggested_frame(canvas: Canvas, place: TilePlace, robot: int, key: str) -> None:
    """Draw the dashed frame of a suggested robot (index from 0): which key accepts it."""
    frame = frame_rect(canvas, place)
    body = place.body
    edge = canvas.u(FRAME)
    box = pygame.Rect(frame.left, body.top - edge, frame.width, frame.bottom - body.top + edge)
    canvas.surface.fill(palette.INK, box)
    inner = body.inflate(2, 2)
    canvas.surface.fill(palette.CARD, inner)
    _dashes(canvas, box, edge)
    canvas.surface.fill(palette.CARD, inner)
    if not place.bar:
        return
    bar = pygame.Rect(frame.left, frame.top, frame.width, body.top - frame.top)
    canvas.box(bar, canvas.u(5), palette.ORANGE, palette.INK, canvas.u(1.5))
    size, height = canvas.u(20), canvas.u(22)
    cap = canvas.text_width(key, size * 0.85, "bold") + canvas.u(14)
    x = bar.left + canvas.u(14)
    x = canvas.write("Press", x, bar.centery, size, weight="semibold").right + canvas.u(8)
    canvas.box(
        pygame.Rect(x, round(bar.centery - height / 2), cap, height), canvas.u(5), palette.CARD,
        palette.INK, canvas.u(1.2),
    )  # fmt: skip
    canvas.write(key, x + cap / 2, bar.centery, size * 0.85, weight="bold", align="centre")
    canvas.write(
        f"to drive {robot + 1}", x + cap + canvas.u(8), bar.centery, size,
        weight="semibold", width=bar.right - x - cap - canvas.u(12),
    )  # fmt: skip


def _dashes(canvas: Canvas, box: pygame.Rect, edge: int) -> None:
    """Fill the edge of a box with orange dashes on ink."""
    dash, pitch = canvas.u(14), canvas.u(24)
    rim = max(1, canvas.u(1))
    for x in range(box.left + rim, box.right, pitch):
        width = min(dash, box.right - rim - x)
        for y in (box.top + rim, box.bottom - edge + rim):
            canvas.surface.fill(palette.ORANGE, (x, y, width, edge - 2 * rim))
    for y in range(box.top + rim, box.bottom, pitch):
        height = min(dash, box.bottom - rim - y)
        for x in (box.left + rim, box.right - edge + rim):
            canvas.surface.fill(palette.ORANGE, (x, y, edge - 2 * rim, height))
