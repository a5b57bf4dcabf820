"""The strip at the bottom of a fleet run: what each mark means."""

from __future__ import annotations

from typing import Literal

import pygame

from study.events.scene import Role
from study.messages import noted
from study.screens import Cue
from study.shell.drawing import chrome, cues, marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.robots import DART, DROP_TIP, draw_robot

Item = Literal["driven", "autonomous", "suggested", "stuck"] | Role

WORDS: dict[Item, str] = {
    "driven": noted("your robot"),
    "autonomous": noted("drives itself"),
    "suggested": noted("suggested"),
    "hazard": noted("hazard: costs health"),
    "health_pack": noted("health pack"),
    "start": noted("start"),
    "goal": noted("goal"),
    "stuck": noted("no progress"),
}
WIDTHS: dict[Item, int] = {
    "driven": 36, "autonomous": 26, "suggested": 38, "hazard": 40, "health_pack": 22,
    "start": 26, "goal": 22, "stuck": 88,
}  # fmt: skip
"""Design pixels."""
SPACE = 9


def height(canvas: Canvas) -> int:
    """Return the height of the strip, pixels."""
    return canvas.u(52 if chrome.is_tall(canvas) else 42)


def draw(canvas: Canvas, items: list[Item]) -> None:
    """Draw the legend, spread over the width of the window."""
    strip = pygame.Rect(0, canvas.size[1] - height(canvas), canvas.size[0], height(canvas))
    canvas.surface.fill(palette.CARD, strip)
    canvas.surface.fill(palette.LINE, (0, strip.top, strip.width, 1))
    scale = canvas.scale
    while items:
        with canvas.at(scale):
            widths = [_width(canvas, item) for item in items]
            room = canvas.size[0] - canvas.u(32)
            least = sum(widths) + canvas.u(14) * (len(items) - 1)
            # Below this size the whole screen is too large for its window.
            if least <= room or scale < 0.6:
                gap = min(canvas.u(48), (room - sum(widths)) // max(1, len(items) - 1))
                x = (canvas.size[0] - sum(widths) - gap * (len(items) - 1)) // 2
                for item, width in zip(items, widths, strict=True):
                    _draw_item(canvas, item, x, strip.centery)
                    left = x + canvas.u(WIDTHS[item]) + canvas.u(SPACE)
                    canvas.write(canvas.say(WORDS[item]), left, strip.centery, canvas.u(18))
                    x += width + gap
                return
        scale *= 0.96


def _width(canvas: Canvas, item: Item) -> int:
    words = canvas.text_width(canvas.say(WORDS[item]), canvas.u(18))
    return canvas.u(WIDTHS[item]) + canvas.u(SPACE) + words


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
        cues.draw_pill(canvas, Cue("stuck", 0.0, 0), left, y, u(15), width,
                       canvas.say("STUCK"))  # fmt: skip


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
