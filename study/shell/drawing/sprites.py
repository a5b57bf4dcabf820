"""Smooth shapes: painted four times too large, scaled down and kept.

pygame's polygons have jagged edges. Averaging 16 samples a pixel smooths them, and each shape is
made once. Sprites hold premultiplied colours: scaling straight alpha would darken their edges.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable

import pygame

from study.shell.drawing.kept import Kept

SAMPLES = 4
"""Samples a pixel along each axis."""
ROOM = 32 << 20
"""Bytes of all sprites together. The bulk of them are robots, one for each heading drawn."""

Paint = Callable[[pygame.Surface, float], None]


class Sprites:
    """A cache of smooth shapes."""

    def __init__(self) -> None:
        self._made = Kept(ROOM)

    @property
    def bytes(self) -> int:
        """What all shapes kept take."""
        return self._made.bytes

    def clear(self) -> None:
        """Keep none."""
        self._made.clear()

    def get(self, key: Hashable, width: float, height: float, paint: Paint) -> pygame.Surface:
        """Return the shape of this key, painted the first time.

        Args:
            key: all that the shape depends on, its size included.
            width: pixels, rounded up.
            height: pixels, rounded up.
            paint: called with a surface ``SAMPLES`` times larger and with that factor.

        Returns:
            A surface to be blitted with ``pygame.BLEND_PREMULTIPLIED``.
        """
        found = self._made.get(key)
        if found is not None:
            return found
        size = (max(1, math.ceil(width)), max(1, math.ceil(height)))
        large = pygame.Surface((size[0] * SAMPLES, size[1] * SAMPLES), pygame.SRCALPHA)
        paint(large, float(SAMPLES))
        sprite = pygame.transform.smoothscale(large.premul_alpha(), size)
        self._made.keep(key, sprite)
        return sprite
