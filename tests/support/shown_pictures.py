"""What a participant's window showed at a time, drawn from the screens that were shown."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pygame

from study.screens import CountdownScreen, FleetScreen, Screen
from study.shell.drawing.renderer import Renderer

SIZE = (1280, 960)
Pixels = npt.NDArray[np.uint8]


def draw_without_window() -> None:
    """Make drawing possible where no window is open."""
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    pygame.font.init()


class Gallery:
    """Draws screens in their order, as a window does, without anything of a replay.

    Args:
        seen: every screen that was shown, with its session time, ns.
        size: of the pictures, pixels.
    """

    def __init__(self, seen: Sequence[tuple[int, Screen]], size: tuple[int, int] = SIZE) -> None:
        draw_without_window()
        self._seen = list(seen)
        self._surface = pygame.Surface(size)
        self._renderer = Renderer(size)
        self._next = 0
        self._screen: Screen | None = None

    def at(self, t_ns: int) -> Pixels:
        """Return the picture at a session time, uint8 [height, width, 3]; times ascend."""
        while self._next < len(self._seen) and self._seen[self._next][0] <= t_ns:
            shown_ns, self._screen = self._seen[self._next]
            if isinstance(self._screen, FleetScreen | CountdownScreen):
                self._renderer.draw(self._surface, self._screen, shown_ns)
            self._next += 1
        assert self._screen is not None
        self._renderer.draw(self._surface, self._screen, t_ns)
        return pygame.surfarray.array3d(self._surface).swapaxes(0, 1)


def picture_at(seen: Sequence[tuple[int, Screen]], t_ns: int) -> Pixels:
    """Return one picture; screens long before it are left out."""
    near = [item for item in seen if t_ns - 30_000_000_000 <= item[0]]
    earlier = [item for item in seen if item[0] < t_ns - 30_000_000_000]
    return Gallery([*earlier[-1:], *near]).at(t_ns)
