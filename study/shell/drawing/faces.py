"""The fonts that come with the program, and which letters are in them."""

from __future__ import annotations

import contextlib
import functools
from pathlib import Path
from typing import Literal

import pygame

from study.shell.drawing.glyphs import letters_of

Weight = Literal["medium", "semibold", "bold"]

FONTS = Path(__file__).parent.parent / "fonts"
FILES: dict[Weight, str] = {
    "medium": "Inter-Medium.otf",
    "semibold": "Inter-SemiBold.otf",
    "bold": "Inter-Bold.otf",
}
OTHER_FILES: dict[Weight, str] = {
    "medium": "DejaVuSans.ttf",
    "semibold": "DejaVuSans-Bold.ttf",
    "bold": "DejaVuSans-Bold.ttf",
}
"""What shows the letters that Inter lacks: its capitals and small letters are as tall."""
CAP_HEIGHT = 0.727
"""Height of Inter's capitals as a share of the font's size."""
SOFT_HYPHEN = "\u00ad"
"""Has a glyph, but no width: a line of it alone cannot be rendered."""


@functools.lru_cache(maxsize=256)
def font(weight: Weight, size: int) -> pygame.font.Font:
    """Return Inter in a weight and size (pixels of the em square)."""
    return pygame.font.Font(FONTS / FILES[weight], size)


@functools.lru_cache(maxsize=64)
def other_font(weight: Weight, size: int, script: str = "") -> pygame.font.Font:
    """Return the font of the letters that Inter lacks.

    Args:
        weight: of Inter beside it.
        size: pixels of the em square.
        script: four letters (ISO 15924) of one that is written from right to left, or empty.
    """
    found = pygame.font.Font(FONTS / OTHER_FILES[weight], size)
    if script:
        # Where pygame was built without HarfBuzz letters stand as they were typed, not joined.
        with contextlib.suppress(pygame.error):
            found.set_direction(pygame.DIRECTION_RTL)
            found.set_script(script)
    return found


@functools.lru_cache(maxsize=256)
def digit_cell(weight: Weight, size: int) -> int:
    """Return the width of Inter's widest digit, pixels."""
    return max(font(weight, size).size(digit)[0] for digit in "0123456789")


def clear() -> None:
    """Forget all fonts: they die with ``pygame.font.quit()``."""
    font.cache_clear()
    other_font.cache_clear()
    digit_cell.cache_clear()


@functools.cache
def _own_letters() -> frozenset[str]:
    """Return what all weights of Inter have."""
    sets = [letters_of(FONTS / file) for file in FILES.values()]
    return frozenset.intersection(*sets) - {SOFT_HYPHEN}


def other_letters(weight: Weight) -> frozenset[str]:
    """Return the characters of the font beside Inter; all of Inter's are among them."""
    return letters_of(FONTS / OTHER_FILES[weight])


def is_own(text: str) -> bool:
    """Return whether a text is drawn in Inter alone, as nearly all are."""
    return (text.isascii() and text.isprintable()) or _own_letters().issuperset(text)
