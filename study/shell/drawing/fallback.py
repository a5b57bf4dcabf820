"""Lines with letters that Inter lacks: in another font, or a box for what no font has.

A line is cut into stretches that lie side by side on one baseline. A word is written in one font,
so that no letter stands out in it. Letters of scripts from right to left are laid and joined within
their stretch; the stretches themselves stand from left to right, as they were typed.
"""

from __future__ import annotations

import functools
import itertools
import re
import unicodedata
from collections.abc import Iterator

import pygame

from study.shell.drawing.faces import (
    CAP_HEIGHT,
    Weight,
    digit_cell,
    font,
    is_own,
    other_font,
    other_letters,
)
from study.shell.drawing.palette import Colour

OWN, OTHER, BOX, DIGIT = "own", "other", "box", "digit"
ARABIC, HEBREW, NKO = "Arab", "Hebr", "Nkoo"
"""Kinds of stretches. Scripts from right to left are named as in ISO 15924."""
RIGHT_TO_LEFT = frozenset({ARABIC, HEBREW, NKO})
WORDS = re.compile(" +|[^ ]+")
JOINERS = frozenset("\u200c\u200d")
"""Have no look, but letters beside them are joined, or not."""
VARIANTS = frozenset(map(chr, (*range(0xFE00, 0xFE10), *range(0xE0100, 0xE01F0))))
"""Have no look, but choose one of several for the character before them."""
BOX_WIDTH = 0.58
BOX_GAP = 0.08
BOX_EDGE = 0.06
"""Of what no font has, as shares of the size; as tall as capitals; the gap is on either side."""


def width_of(text: str, weight: Weight, size: int, *, tabular: bool = False) -> int:
    """Return the width of a line in pixels (see `lettering.text_width`)."""
    return sum(
        _width(kind, part, weight, size) for kind, part in stretches(text, weight, tabular=tabular)
    )


def ascent_of(text: str, weight: Weight, size: int) -> int:
    """Return how far a line's picture reaches above its baseline, pixels: at least as Inter's."""
    above = [font(weight, size).get_ascent()]
    for kind, part in stretches(text, weight):
        if kind not in (OWN, DIGIT, BOX):
            above.append(_reach(_other(kind, weight, size), part))
    return max(above)


def picture_of(
    text: str, weight: Weight, size: int, colour: Colour, *, tabular: bool = False
) -> pygame.Surface:
    """Return a rendered line, whose baseline is `ascent_of` pixels under its upper edge."""
    own, ascent = font(weight, size), ascent_of(text, weight, size)
    placed: list[tuple[pygame.Surface, int, int]] = []
    x = 0
    for kind, part in stretches(text, weight, tabular=tabular):
        width = _width(kind, part, weight, size)
        if kind == DIGIT:
            cell = digit_cell(weight, size)
            for place, digit in enumerate(part):
                drawn = own.render(digit, antialias=True, color=colour)
                left = x + place * cell + (cell - drawn.get_width()) // 2
                placed.append((drawn, left, ascent - own.get_ascent()))
        elif kind == BOX:
            drawn = _boxes(len(part), size, colour)
            placed.append((drawn, x, ascent - drawn.get_height()))
        elif width:
            # What has no width, such as a joiner alone, cannot be rendered.
            used = own if kind == OWN else _other(kind, weight, size)
            above = own.get_ascent() if kind == OWN else _reach(used, part)
            placed.append((used.render(part, antialias=True, color=colour), x, ascent - above))
        x += width
    height = ascent + own.get_height() - own.get_ascent()
    lowest = max((top + drawn.get_height() for drawn, _, top in placed), default=0)
    surface = pygame.Surface((x, max(height, lowest)), pygame.SRCALPHA)
    for drawn, left, top in placed:
        surface.blit(drawn, (left, top))
    return surface


def lacking(text: str, weight: Weight) -> set[str]:
    """Return the characters of a text that are drawn as boxes."""
    return {letter for kind, part in stretches(text, weight) if kind == BOX for letter in part}


def forget() -> None:
    """Remember no text."""
    stretches.cache_clear()


@functools.lru_cache(maxsize=64)
def stretches(text: str, weight: Weight, *, tabular: bool = False) -> tuple[tuple[str, str], ...]:
    """Cut a line into stretches drawn in one way.

    Args:
        text: the line.
        weight: of the font.
        tabular: whether digits stand in cells of their own.

    Returns:
        The kind and the characters of each, from the left.
    """
    shown = "".join(_shown(text, other_letters(weight)))
    kinds: list[str] = []
    for word in WORDS.findall(shown):
        kinds += [OWN] * len(word) if is_own(word) else _kinds(word, other_letters(weight))
    for blank in re.finditer(" +", shown):
        first, end = blank.span()
        around = kinds[max(0, first - 1) : first] + kinds[end : end + 1]
        if len(around) == 2 and around[0] == around[1] != BOX:
            kinds[first:end] = around[:1] * (end - first)
    if tabular:
        kinds = [
            DIGIT if letter.isdigit() and is_own(letter) else kind
            for kind, letter in zip(kinds, shown, strict=True)
        ]
    pairs = itertools.groupby(zip(kinds, shown, strict=True), key=lambda pair: pair[0])
    return tuple((kind, "".join(letter for _, letter in group)) for kind, group in pairs)


def _shown(text: str, there: frozenset[str]) -> Iterator[str]:
    """Yield the characters of a text that have a look; a letter and its accent become one."""
    for letter in unicodedata.normalize("NFC", text):
        if letter.isspace():
            yield letter if is_own(letter) else " "
            continue
        category = unicodedata.category(letter)
        # Of the characters that say how others are shown these have a look: signs of numbers.
        looks = letter in JOINERS or unicodedata.bidirectional(letter) == "AN"
        if category == "Cc" or (category == "Cf" and not looks) or letter in VARIANTS:
            continue
        apart = unicodedata.normalize("NFD", letter)
        # Of some letters the font has the parts alone.
        yield apart if letter not in there and there.issuperset(apart) else letter


def _kinds(word: str, there: frozenset[str]) -> list[str]:
    """Return how each character of a word is drawn of which Inter lacks one."""
    drawn = [letter for letter in word if letter in there]
    usual = OWN if is_own("".join(drawn)) else OTHER
    kinds = [_kind(letter, usual) if letter in there else BOX for letter in word]
    # Signs and marks go with the letter before them, or with the first.
    last = next((kind for kind in kinds if kind not in ("", BOX)), usual)
    for place, kind in enumerate(kinds):
        if not kind:
            kinds[place] = last
        elif kind != BOX:
            last = kind
    return kinds


def _kind(letter: str, usual: str) -> str:
    """Return the script of a letter from right to left, nothing for a sign, or what is usual."""
    match unicodedata.bidirectional(letter):
        case "AL":
            return ARABIC
        case "R":
            return NKO if "\u07c0" <= letter <= "\u07ff" else HEBREW
        case "L" | "EN" | "AN":
            return usual
        case _:
            return ""


def _other(kind: str, weight: Weight, size: int) -> pygame.font.Font:
    return other_font(weight, size, kind if kind in RIGHT_TO_LEFT else "")


def _width(kind: str, part: str, weight: Weight, size: int) -> int:
    if kind == BOX:
        return len(part) * _box_cell(size)
    if kind == DIGIT:
        return len(part) * digit_cell(weight, size)
    used = font(weight, size) if kind == OWN else _other(kind, weight, size)
    return used.size(part)[0]


def _reach(used: pygame.font.Font, part: str) -> int:
    """Return how far a stretch's picture reaches above its baseline, pixels.

    A letter with two accents, one above the other, may be taller than its font: the picture is
    then taller by as much.
    """
    tallest = max((outline[3] for outline in used.metrics(part) or () if outline), default=0)
    return max(used.get_ascent(), tallest)


def _box_cell(size: int) -> int:
    return max(3, round(size * (BOX_WIDTH + 2 * BOX_GAP)))


def _boxes(count: int, size: int, colour: Colour) -> pygame.Surface:
    """Return boxes side by side that stand on the lower edge."""
    cell, gap = _box_cell(size), max(1, round(size * BOX_GAP)) if size > 2 else 0
    height = max(1, round(size * CAP_HEIGHT))
    surface = pygame.Surface((count * cell, height), pygame.SRCALPHA)
    edge = max(1, round(size * BOX_EDGE))
    for number in range(count):
        place = pygame.Rect(number * cell + gap, 0, max(1, cell - 2 * gap), height)
        pygame.draw.rect(surface, colour, place, edge)
    return surface
