"""The strip at the bottom of a fleet run: what each mark means."""

from __future__ import annotations

from typing import Literal

import pygame

from study.events.scene import Role
from study.screens import Cue
from study.shell.drawing import chrome, cues, marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.robots import DART, DROP_TIP, draw_robot

Item = Literal["driven", "autonomous", "suggested", "stuck"] | Role

WORDS: dict[Item, str] = {
    "driven": "your robot",
    "autonomous": "drives itself",
    "suggested": "suggested",
    "hazard": "hazard: costs health",
    "health_pack": "health pack",
    "start": "start",
    "goal": "goal",
    "stuck": "no progress",
}
WIDTHS: dict[Item, int] = {
    "driven": 36, "autonomous": 26, "suggested": 38, "hazard": 40, "health_pack": 22,
    "start": 26, "goal": 22, "stuck": 88,
}  # fmt: skip
"""Design pixels."""


def height(canvas: Canvas) -> int:
    """Return the height of the strip, pixels."""
    return canvas.u(52 if chrome.is_tall(canvas) else 42)


def draw(canvas: Canvas, items: list[Item]) -> None:
    """Draw the legend, spread over the width of the window."""
    strip = pygame.Rect(0, canvas.size[1] - height(canvas), canvas.size[0], height(canvas))
    canvas.surface.fill(palette.CARD, strip)
    canvas.surface.fill(palette.LINE, (0, strip.top, strip.width, 1))
    u = canvas.u
    size, space = u(18), u(9)
    room = canvas.size[0] - u(48)
    while True:
        widths = [u(WIDTHS[item]) + space + canvas.text_width(WORDS[item], size) for item in items]
        if sum(widths) + u(16) * len(items) <= room or size <= u(14):
            break
        size -= 1
    gap = min(u(48), (room - sum(widths)) // max(1, len(items) - 1))
    x = (canvas.size[0] - sum(widths) - gap * (len(items) - 1)) // 2
    for item, width in zip(items, widths, strict=True):
        _draw_item(canvas, item, x, strip.centery)
        canvas.write(WORDS[item], x + u(WIDTHS[item]) + space, strip.centery, size)
        x += width + gap


def _draw_item(canvas: Canvas, item: Item, left: int, y: int) -> None:
    u = canvas.u
    width = u(WIDTHS[item])
    x = left + width / 2
    if item == "driven":
        draw_dart(canvas, x, y, u(12))
    elif item == "autonomous":
        radius = u(9)
        draw_robot(canvas, x - radius * (DROP_TIP - 1) / 2, y, radius, 0.0, driven=False)
    elif item == "suggested":
        _suggested(canvas, pygame.Rect(left, y - u(13), width, u(26)))
    elif item == "hazard":
        marks.hatch(canvas, pygame.Rect(left, y - u(13), width, u(26)), u(7))
    elif item == "health_pack":
        marks.health_cross(canvas, x, y, u(20))
    elif item == "start":
        marks.dashed_ring(canvas, x, y, u(12), u(1.6), palette.SECONDARY, dashes=14)
        canvas.write("S", x, y, u(12), weight="bold", colour=palette.SECONDARY, align="centre")
    elif item == "goal":
        marks.flag(canvas, x, y, u(22))
    elif item == "stuck":
        cues.draw_pill(canvas, Cue("stuck", 0.0, 0), left, y, u(15), width, "STUCK")


def draw_dart(canvas: Canvas, x: float, y: float, size: float) -> None:
    """Draw the dart of a driven robot without its ring, pointing right."""

    def paint(surface: pygame.Surface, k: float) -> None:
        middle = surface.get_rect().centerx
        points = [(middle + (px - 0.3) * size * k, middle + py * size * k) for px, py in DART]
        pygame.draw.polygon(surface, palette.BLUE, points)

    canvas.put(canvas.sprite(("dart", round(size)), 3.4 * size, 3.4 * size, paint), x, y)


def _suggested(canvas: Canvas, place: pygame.Rect) -> None:
    edge, dash = canvas.u(4), canvas.u(8)
    canvas.surface.fill(palette.INK, place)
    for x in range(place.left + 1, place.right, dash + canvas.u(4)):
        width = min(dash, place.right - 1 - x)
        canvas.surface.fill(palette.ORANGE, (x, place.top + 1, width, place.height - 2))
    canvas.surface.fill(palette.ORANGE_TINT, place.inflate(-2 * edge, -2 * edge))
