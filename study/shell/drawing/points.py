"""The row of cards that says what gives and costs points."""

from __future__ import annotations

import pygame

from study.events.task_description import RewardTerm
from study.screens import PageScreen
from study.shell.drawing import chrome, marks, palette
from study.shell.drawing.canvas import Canvas


def row_height(canvas: Canvas) -> int:
    """Return the height of the row, pixels."""
    return canvas.u(184 if chrome.is_tall(canvas) else 156)


def value_text(term: RewardTerm) -> str:
    """Return a term's points with their sign; health goes both ways."""
    number = f"{abs(term.value):g}"
    if term.name == "health":
        return f"±{number}"
    return f"−{number}" if term.value < 0 else f"+{number}"


def draw(canvas: Canvas, screen: PageScreen, place: pygame.Rect) -> None:
    """Draw the row of points rules."""
    u, tall = canvas.u, chrome.is_tall(canvas)
    y = place.top + u(31 if tall else 25)
    title = canvas.write(canvas.say("Points"), place.left + u(24), y, u(22), weight="semibold")
    canvas.write(canvas.say("added up over all robots"), title.right + u(16), y, u(19),
                 colour=palette.SECONDARY, width=place.right - u(40) - title.right)  # fmt: skip
    top = place.top + u(56 if tall else 46)
    width = (place.width - u(48)) / max(1, len(screen.rewards))
    for number, term in enumerate(screen.rewards):
        left = place.left + u(24) + round(number * width)
        column = pygame.Rect(left, top, round(width) - u(20), place.bottom - u(14) - top)
        if number:
            bottom = place.bottom - u(20)
            canvas.surface.fill(palette.LINE, (left - u(14), top + u(4), 1, bottom - top))
        _draw_term(canvas, screen, term, column)


def _draw_term(canvas: Canvas, screen: PageScreen, term: RewardTerm, column: pygame.Rect) -> None:
    u, tall = canvas.u, chrome.is_tall(canvas)
    y = column.top + u(28 if tall else 24)
    value = canvas.write(value_text(term), column.left, y, u(40), weight="bold",
                         width=column.width - u(40))  # fmt: skip
    _draw_picture(canvas, term.name, max(value.right + u(34), column.right - u(34)), y)
    text = canvas.say(term.text)
    if term.name == "timestep" and not text:
        text = canvas.say("({number} a second)", number=f"{screen.timesteps_per_second:g}")
    canvas.write(
        canvas.say(term.per), column.left, y + u(40), u(19), weight="semibold", width=column.width
    )
    canvas.write(text, column.left, y + u(65), u(19), colour=palette.SECONDARY,
                 width=column.width)  # fmt: skip


def _draw_picture(canvas: Canvas, name: str, x: float, y: float) -> None:
    u = canvas.u
    if name == "progress":
        marks.arrow(canvas, x, y, u(32), "right", palette.SECONDARY, u(3))
    elif name == "goal":
        marks.flag(canvas, x, y, u(30))
    elif name == "health":
        marks.health_cross(canvas, x - u(15), y, u(24))
        marks.hatch(canvas, pygame.Rect(round(x + u(3)), round(y - u(12)), u(24), u(24)), u(8))
    elif name == "lost":
        marks.disc(canvas, x, y, u(15), palette.INK)
        marks.saltire(canvas, x, y, u(22), palette.CARD, u(3))
    elif name == "timestep":
        marks.clock(canvas, x, y, u(32), palette.SECONDARY)
