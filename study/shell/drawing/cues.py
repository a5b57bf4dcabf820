"""Cues: the pill in a tile's plate, the plate's tint and the mark at the robot."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import pygame

from study.messages import Messages, noted
from study.screens import Cue, CueKind
from study.shell.drawing import marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.lettering import has_digit
from study.shell.drawing.palette import Colour


@dataclasses.dataclass(frozen=True, slots=True)
class PillStyle:
    """Colours of a cue's pill, and of the plate behind it."""

    fill: Colour
    edge: Colour
    text: Colour
    tint: Colour | None


STYLES: dict[CueKind, PillStyle] = {
    "held": PillStyle(palette.INK, palette.CARD, palette.CARD, palette.PLATE),
    "lost": PillStyle(palette.INK, palette.CARD, palette.CARD, palette.VERMILLION_TINT),
    "time_up": PillStyle(palette.CARD, palette.INK, palette.INK, None),
    "goal": PillStyle(palette.GREEN_TEXT, palette.CARD, palette.CARD, palette.GREEN_TINT),
    "damage": PillStyle(
        palette.VERMILLION_TEXT, palette.CARD, palette.CARD, palette.VERMILLION_TINT
    ),
    "stuck": PillStyle(palette.YELLOW, palette.INK, palette.INK, palette.YELLOW_TINT),
    "low": PillStyle(palette.CARD, palette.VERMILLION_TEXT, palette.VERMILLION_TEXT, None),
    "pack": PillStyle(palette.CARD, palette.GREEN_TEXT, palette.GREEN_TEXT, None),
}


NUMBER_STEP = 0.5
"""Steps in which pills with numbers grow, in sizes of their text."""


def points(amount: float) -> str:
    """Return health points without a sign; a decimal only where there is one."""
    amount = abs(amount)
    return f"{amount:.0f}" if abs(amount - round(amount)) < 0.05 else f"{amount:.1f}"


WORDS: dict[CueKind, str] = {
    "held": noted("WAITS"),
    "lost": noted("LOST"),
    "time_up": noted("TIME UP"),
    "goal": noted("GOAL"),
    "stuck": noted("STUCK"),
    "low": noted("LOW"),
}


def pill_text(messages: Messages, cue: Cue, *, short: bool = False) -> str:
    """Return the words of a cue's pill."""
    if cue.kind == "damage":
        return f"−{points(cue.amount)}"
    if cue.kind == "pack":
        return f"+{points(cue.amount)}"
    if cue.kind == "stuck" and not short:
        return messages.say("STUCK {seconds} s", seconds=f"{cue.amount:.0f}")
    if cue.kind == "time_up" and short:
        return messages.say("TIME")
    return messages.say(WORDS[cue.kind])


def _bars(canvas: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    width, height = max(2, round(size * 0.22)), round(size * 0.8)
    for side in (-1, 1):
        left = round(x + side * size * 0.22 - width / 2)
        canvas.surface.fill(colour, (left, round(y - height / 2), width, height))


def _dots(canvas: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    for side in (-1, 0, 1):
        marks.disc(canvas, x + side * size * 0.36, y, max(1.0, size * 0.13), colour)


def _sign(kind: CueKind) -> Callable[[Canvas, float, float, float, Colour], object]:
    stroke = 0.19
    signs: dict[CueKind, Callable[[Canvas, float, float, float, Colour], object]] = {
        "held": _dots,
        "lost": lambda c, x, y, s, k: marks.saltire(c, x, y, s * 1.1, k, s * stroke),
        "time_up": lambda c, x, y, s, k: marks.clock(c, x, y, s * 1.1, k),
        "goal": lambda c, x, y, s, k: marks.tick(c, x, y, s * 1.1, k, s * stroke),
        "damage": lambda c, x, y, s, k: marks.triangle_down(c, x, y, s * 0.85, k),
        "stuck": _bars,
        "low": lambda c, x, y, s, k: c.write(
            "!", x, y, s * 1.3, weight="bold", colour=k, align="centre"
        ),
        "pack": lambda c, x, y, s, k: marks.health_cross(c, x, y, s * 0.95, k),
    }
    return signs[kind]


def draw_pill(
    canvas: Canvas, cue: Cue, x: float, y: float, size: float, room: float, text: str | None = None
) -> pygame.Rect:
    """Draw a cue's pill from its left edge at x, its middle at y.

    Args:
        canvas: to draw on.
        cue: what happened.
        x: left edge, pixels.
        y: middle, pixels.
        size: of the text, pixels.
        room: greatest width, pixels: long words and the sign give way.
        text: words instead of the cue's own.
    """
    style = STYLES[cue.kind]
    words = text if text is not None else pill_text(canvas.messages, cue)
    pad, sign = size * 0.5, size * 0.8

    def width_of(shown: str, *, signed: bool) -> float:
        mark = sign + size * 0.3 if signed else 0.0
        return 2 * pad + mark + canvas.text_width(shown, size, "bold")

    if not canvas.fits(pill_text(canvas.messages, cue, short=True) if text is None else text,
                       size, room - 4, "bold"):  # fmt: skip
        return draw_sign(canvas, cue, x + size * SIGN_EDGE, y, size)
    signed = True
    if width_of(words, signed=True) > room:
        words = text if text is not None else pill_text(canvas.messages, cue, short=True)
        signed = width_of(words, signed=True) <= room
    width = needed = width_of(words, signed=signed)
    if has_digit(words):
        # A box of its own for each number would be painted and kept, the rare ones late.
        step = max(1, round(size * NUMBER_STEP))
        width = step * math.ceil(needed / step)
    width = min(width, room)
    slack = max(0.0, width - needed)
    place = pygame.Rect(round(x), round(y - size * 0.75), round(width), round(size * 1.5))
    canvas.box(place, size * 0.3, style.fill, style.edge, max(1.5, size * 0.09))
    left = place.left + pad + slack / 2
    if signed:
        _sign(cue.kind)(canvas, left + sign / 2, place.centery, sign, style.text)
        left += sign + size * 0.3
    room_left = place.right - left - (pad if signed else size * 0.2)
    if not signed:
        canvas.write(words, place.centerx, place.centery, size, weight="bold",
                     colour=style.text, align="centre", width=place.width - 4)  # fmt: skip
    else:
        canvas.write(words, left, place.centery, size, weight="bold", colour=style.text,
                     width=room_left + 2)  # fmt: skip
    return place


def draw_sign(canvas: Canvas, cue: Cue, right: float, y: float, size: float) -> pygame.Rect:
    """Draw a cue's sign without words, its right edge given: for plates too small for a pill."""
    style = STYLES[cue.kind]
    edge = round(size * SIGN_EDGE)
    place = pygame.Rect(round(right) - edge, round(y - edge / 2), edge, edge)
    canvas.box(place, size * 0.3, style.fill, style.edge, max(1.5, size * 0.09))
    _sign(cue.kind)(canvas, place.centerx, place.centery, size * 0.8, style.text)
    return place


def draw_veil(canvas: Canvas, place: pygame.Rect) -> None:
    """Dim what a tile shows, and put a clock on it: it stands still, and is no news."""
    veil = pygame.Surface(place.size)
    veil.fill(palette.PAGE)
    veil.set_alpha(VEIL)
    canvas.surface.blit(veil, place)
    radius = 0.16 * min(place.size)
    marks.disc(canvas, *place.center, radius, palette.CARD)
    marks.clock(canvas, *place.center, 1.5 * radius, palette.INK)


VEIL = 150
"""Opacity of what dims a tile, of 255."""
SIGN_EDGE = 1.4
"""Width of a sign's box in sizes of its text."""


def draw_mark(canvas: Canvas, cue: Cue, x: float, y: float, radius: float, *, driven: bool) -> None:
    """Draw a cue's mark behind a robot of this radius; larger behind a driven one."""
    reach = radius * (3.6 if driven else 2.2)
    line = max(1.5, radius * 0.16)
    if cue.kind == "damage":
        marks.burst(canvas, x, y, reach * 1.12, line)
    elif cue.kind == "stuck":
        marks.dashed_ring(canvas, x, y, reach, line, palette.INK, dashes=16, fill=palette.YELLOW)
    elif cue.kind == "pack":
        marks.ring(canvas, x, y, reach * 1.12, line * 0.6, palette.GREEN, alpha=0.6)
        marks.ring(canvas, x, y, reach * 0.95, line, palette.GREEN)
    elif cue.kind == "goal":
        marks.ring(canvas, x, y, reach, line, palette.GREEN_TEXT, fill=palette.GREEN_TINT)
    elif cue.kind == "lost":
        marks.ring(canvas, x, y, reach, line, palette.INK, fill=palette.VERMILLION_TINT)
