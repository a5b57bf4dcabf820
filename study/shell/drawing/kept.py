"""Pictures kept while there is room for them: the one used longest ago goes first."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Iterator
from contextlib import contextmanager

import pygame


class Kept:
    """Surfaces by key, of at most so many bytes together.

    Bounded by bytes and not by number: of the largest window's sprites a thousand are as large as
    all else that a session holds, and memory that grows for an hour is found in the last trial.

    Args:
        room: bytes.
    """

    def __init__(self, room: int) -> None:
        self._room = room
        self._bytes = 0
        self._closed = False
        self._surfaces: OrderedDict[Hashable, pygame.Surface] = OrderedDict()

    def __len__(self) -> int:
        return len(self._surfaces)

    @property
    def bytes(self) -> int:
        """What all of them take."""
        return self._bytes

    def get(self, key: Hashable) -> pygame.Surface | None:
        """Return what is kept under a key, or None."""
        found = self._surfaces.get(key)
        if found is not None:
            self._surfaces.move_to_end(key)
        return found

    def keep(self, key: Hashable, surface: pygame.Surface) -> None:
        """Keep a surface under a key that has none; others make room. The newest always stays."""
        if self._closed:
            return
        self._surfaces[key] = surface
        self._bytes += size_of(surface)
        while self._bytes > self._room and len(self._surfaces) > 1:
            _, gone = self._surfaces.popitem(last=False)
            self._bytes -= size_of(gone)

    @contextmanager
    def closed(self) -> Iterator[None]:
        """Keep no more than there is, meanwhile."""
        before, self._closed = self._closed, True
        try:
            yield
        finally:
            self._closed = before

    def clear(self) -> None:
        """Keep nothing."""
        self._surfaces.clear()
        self._bytes = 0


def size_of(surface: pygame.Surface) -> int:
    """Return the bytes of a surface's pixels."""
    return surface.get_pitch() * surface.get_height()
