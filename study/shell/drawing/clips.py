"""Drawing within a place only: what is erased with it may not reach beyond it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pygame


@contextmanager
def clipped(surface: pygame.Surface, place: pygame.Rect) -> Iterator[None]:
    """Draw meanwhile only where a place and what was drawn in before overlap."""
    before = surface.get_clip()
    surface.set_clip(place.clip(before))
    try:
        yield
    finally:
        surface.set_clip(before)
