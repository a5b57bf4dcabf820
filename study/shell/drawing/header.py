"""The strip at the top of a fleet run: part, trial, time left, and the keys in use."""

from __future__ import annotations

import dataclasses
import math

import pygame

from study.screens import FleetScreen
from study.shell.drawing import chrome, palette
from study.shell.drawing.canvas import Canvas

MOST_BOXES = 16
"""Trials beyond which progress is words only."""
CLOCK_BAR = 120
SMALLEST_BAR = 40
MARGIN, GAP = 24, 20
REDUCTION = 0.96


def clock_text(seconds: float) -> str:
    """Return a time left as minutes and seconds; a started second still counts."""
    whole = max(0, math.ceil(seconds - 1e-6))
    return f"{whole // 60}:{whole % 60:02d}"


def key(canvas: Canvas, screen: FleetScreen) -> tuple[object, ...]:
    """Return all that the look of the header depends on."""
    total = max(screen.seconds_total, 1e-9)
    return (
        screen.heading,
        screen.trial,
        screen.trials,
        screen.unit,
        screen.keys,
        clock_text(screen.seconds_left),
        round(screen.seconds_left / total * canvas.u(CLOCK_BAR)),
        screen.seconds_total > 0,
    )


@dataclasses.dataclass(frozen=True, slots=True)
class _Widths:
    """Widths of the header's parts at the canvas's scale, pixels."""

    left: int
    box: int
    clock: int
    keys: int

    @property
    def least(self) -> int:
        """What all takes without the clock's bar."""
        return self.left + self.clock + self.keys


def _trial_words(canvas: Canvas, screen: FleetScreen) -> str:
    if screen.trials <= 0:
        return ""
    return canvas.say(
        "{unit} {number} of {total}",
        unit=screen.unit, number=screen.trial, total=screen.trials,
    )  # fmt: skip


def _measure(canvas: Canvas, screen: FleetScreen, box: int) -> _Widths:
    u = canvas.u
    left = u(MARGIN) + canvas.text_width(screen.heading, u(19), "semibold")
    words = _trial_words(canvas, screen)
    if words:
        left += u(38) + canvas.text_width(words, u(19), "semibold")
    if words and box:
        left += u(15) + screen.trials * (u(box) + u(5))
    clock = u(GAP)
    if screen.seconds_total > 0:
        clock += canvas.text_width("00:00", u(26), "bold", tabular=True) + u(10)
        clock += canvas.text_width(canvas.say("left"), u(18)) + u(GAP)
    pairs = [chrome.keys_width(canvas, *pair, u(29), u(18)) for pair in screen.keys]
    return _Widths(left, box, clock, sum(pairs) + u(18) * max(0, len(pairs) - 1) + u(MARGIN))


def draw(canvas: Canvas, screen: FleetScreen) -> None:
    """Draw part, trial, time left and keys: smaller, and without boxes, where room is short."""
    y = chrome.draw_header_ground(canvas)
    boxes = (12, 8, 0) if 0 < screen.trials <= MOST_BOXES else (0,)
    scale = canvas.scale
    while True:
        with canvas.at(scale):
            for box in boxes:
                widths = _measure(canvas, screen, box)
                if widths.least <= canvas.size[0]:
                    break
            # Capitals of less than 8 pixels cannot be read: then the whole screen is too large.
            if widths.least <= canvas.size[0] or scale < 0.6:
                _draw(canvas, screen, widths, y)
                return
        scale *= REDUCTION


def _draw(canvas: Canvas, screen: FleetScreen, widths: _Widths, y: int) -> None:
    u, size = canvas.u, canvas.u(19)
    x = canvas.write(screen.heading, u(MARGIN), y, size, weight="semibold").right
    words = _trial_words(canvas, screen)
    if words:
        canvas.surface.fill(palette.LINE, (x + u(19), y - u(14), 1, u(28)))
        x = canvas.write(words, x + u(38), y, size, weight="semibold").right
    if words and widths.box:
        x = _progress(canvas, screen, x + u(15), y, u(widths.box))
    left = right = canvas.size[0] - widths.keys
    for label, word in screen.keys:
        left += chrome.draw_keys(canvas, label, word, left, y, u(29), u(18)) + u(18)
    if screen.seconds_total > 0:
        _draw_clock(canvas, screen, x, right, y)


def _progress(canvas: Canvas, screen: FleetScreen, x: int, y: int, width: int) -> int:
    """Draw a box a trial: done, running, to come; return where they end."""
    u = canvas.u
    for trial in range(1, screen.trials + 1):
        box = pygame.Rect(x, y - u(9), width, u(18))
        if trial < screen.trial:
            canvas.box(box, u(2), palette.AUTONOMOUS)
        elif trial == screen.trial:
            canvas.box(box, u(2), palette.CARD, palette.BLUE, u(3))
        else:
            canvas.box(box, u(2), palette.CARD, palette.EDGE, u(1.2))
        x += width + u(5)
    return x


def _draw_clock(canvas: Canvas, screen: FleetScreen, left: int, right: int, y: int) -> None:
    """Draw the time left, in the middle of the window if there is room."""
    u = canvas.u
    text = clock_text(screen.seconds_left)
    room = right - left - u(40)
    number = canvas.text_width(text, u(26), "bold", tabular=True)
    left_word = canvas.say("left")
    word = canvas.text_width(left_word, u(18))
    bar = min(u(CLOCK_BAR), room - number - word - u(22))
    bar = bar if bar >= u(SMALLEST_BAR) else 0
    total = number + u(10) + word + (u(14) + bar if bar else 0)
    middle = canvas.size[0] / 2
    start = max(left + u(20), min(middle - total / 2, right - u(20) - total))
    canvas.write(text, start, y, u(26), weight="bold", tabular=True)
    x = start + number + u(10)
    canvas.write(left_word, x, y + u(2), u(18), colour=palette.SECONDARY)
    if bar:
        box = pygame.Rect(round(x + word + u(14)), y - u(6), bar, u(12))
        canvas.box(box, u(2), palette.CARD, palette.EDGE, max(1, u(1.2)))
        inside = box.inflate(-2 * u(1.6), -2 * u(1.6))
        share = min(1.0, max(0.0, screen.seconds_left / screen.seconds_total))
        inside.width = round(inside.width * share)
        canvas.surface.fill(palette.AUTONOMOUS, inside)
