"""Text on surfaces: fonts, wrapping, shrinking to fit, and a report of what did not fit."""

from __future__ import annotations

import bisect
from contextlib import AbstractContextManager
from typing import Literal

import pygame

from study.shell.drawing import faces, fallback
from study.shell.drawing.faces import Weight, digit_cell, font, is_own
from study.shell.drawing.kept import Kept
from study.shell.drawing.palette import Colour

Align = Literal["left", "centre", "right"]

TEXT_ROOM = 8 << 20
"""Bytes of all lines kept together."""
_LINES = Kept(TEXT_ROOM)
LONGEST_NUMBER = 3
"""Digits of a number that is kept: robots' numbers are written in every picture."""


def clear_fonts() -> None:
    """Forget all fonts: they die with ``pygame.font.quit()``."""
    faces.clear()
    forget_lines()


def forget_lines() -> None:
    """Keep no rendered line."""
    _LINES.clear()
    fallback.forget()


def no_more_lines() -> AbstractContextManager[None]:
    """Keep no further lines meanwhile: those of a page are of no use to what is shown after it."""
    return _LINES.closed()


def has_digit(text: str) -> bool:
    """Return whether a line counts something: it may have hundreds of looks."""
    return any(character.isdigit() for character in text)


def text_width(text: str, weight: Weight, size: int, *, tabular: bool = False) -> int:
    """Return the width of a line in pixels.

    Args:
        text: the line.
        weight: of the font.
        size: of the font, pixels.
        tabular: whether all digits are equally wide, so that a running number stands still.
    """
    if not is_own(text):
        return fallback.width_of(text, weight, size, tabular=tabular)
    if not tabular:
        return font(weight, size).size(text)[0]
    cell = digit_cell(weight, size)
    return sum(cell if c.isdigit() else font(weight, size).size(c)[0] for c in text)


def _tabular(text: str, weight: Weight, size: int, colour: Colour) -> pygame.Surface:
    """Return a line made of kept characters: a running number has hundreds of lines."""
    surface = pygame.Surface(
        (text_width(text, weight, size, tabular=True), font(weight, size).get_height()),
        pygame.SRCALPHA,
    )
    cell = digit_cell(weight, size)
    x = 0
    for character in text:
        glyph = line_surface(character, weight, size, colour)
        width = cell if character.isdigit() else glyph.get_width()
        surface.blit(glyph, (x + (width - glyph.get_width()) // 2, 0))
        x += width
    return surface


def line_surface(
    text: str, weight: Weight, size: int, colour: Colour, *, tabular: bool = False
) -> pygame.Surface:
    """Return a rendered line, which must not be drawn on: it may be kept.

    What counts, points or seconds, is not kept as a line: it would be kept for each number.
    """
    if tabular and is_own(text):
        return _tabular(text, weight, size, colour)
    key = (text, weight, size, colour)
    found = _LINES.get(key)
    if found is None:
        if is_own(text):
            found = font(weight, size).render(text, antialias=True, color=colour)
        else:
            found = fallback.picture_of(text, weight, size, colour, tabular=tabular)
        number = text.isdigit() and len(text) <= LONGEST_NUMBER
        if number or not has_digit(text):
            _LINES.keep(key, found)
    return found


def line_ascent(text: str, weight: Weight, size: int) -> int:
    """Return how far under the upper edge of a rendered line its baseline is, pixels."""
    if is_own(text):
        return font(weight, size).get_ascent()
    return fallback.ascent_of(text, weight, size)


def wrap(text: str, weight: Weight, size: int, width: int) -> list[str]:
    """Break a text into lines at blanks, each at most ``width`` pixels if its words allow it.

    The lines' words, joined by blanks, are the words of the text. A last line of one word is
    avoided where narrower lines do so without adding one.
    """
    lines = _greedy_lines(text, weight, size, width)
    if len(lines) > 1 and " " not in lines[-1]:
        for share in (0.95, 0.9, 0.85, 0.8):
            narrower = _greedy_lines(text, weight, size, int(width * share))
            if len(narrower) == len(lines) and " " in narrower[-1]:
                return narrower
    return lines


def _greedy_lines(text: str, weight: Weight, size: int, width: int) -> list[str]:
    lines: list[str] = []
    current = ""
    for word in text.split():
        longer = f"{current} {word}" if current else word
        if current and text_width(longer, weight, size) > width:
            lines.append(current)
            current = word
        else:
            current = longer
    return [*lines, current] if current else lines


def fitting_size(text: str, weight: Weight, size: int, width: int, smallest: int) -> int:
    """Return the largest size from ``size`` down to ``smallest`` at which a line fits a width."""
    while size > smallest and text_width(text, weight, size) > width:
        size -= 1
    return size


def fitting_end(text: str, weight: Weight, size: int, width: int) -> str:
    """Return as much of a line's end as fits a width."""
    # The width is asked for a few ends alone: of a long text, a line is laid for each.
    first = bisect.bisect_left(
        range(len(text)),
        True,  # noqa: FBT003 - what is searched for
        key=lambda start: text_width(text[start:], weight, size) <= width,
    )
    return text[first:]
