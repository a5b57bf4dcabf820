"""Parts of a screen that are painted once and repeated while they look the same."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable

import pygame

from study.shell.drawing.drawn import Written
from study.shell.drawing.kept import size_of

ALIKE_ROOM = 256 << 10
"""Bytes of small parts that look alike in several places at a time, such as rows of health.

In 900 pictures of twelve tiles of a pilot 603 rows are painted anew, and 254 with sixteen times the
room: a row every other picture is less than memory that fills for a quarter of an hour.
"""


@dataclasses.dataclass(frozen=True, slots=True)
class Part:
    """A part of the screen that was painted: where, what its look depends on, and its texts."""

    place: pygame.Rect
    key: object
    picture: pygame.Surface
    written: tuple[Written, ...]
    boxed: tuple[pygame.Rect, ...]

    def elsewhere(self, place: pygame.Rect, key: object) -> Part:
        """Return the same picture as a part in another place, under a key of its own."""
        across, down = place.left - self.place.left, place.top - self.place.top
        written = tuple(
            dataclasses.replace(text, place=text.place.move(across, down)) for text in self.written
        )
        boxed = tuple(box.move(across, down) for box in self.boxed)
        return Part(place, key, self.picture, written, boxed)


class Parts:
    """The parts of a screen by name, and by their look those that look alike in several places.

    Attributes:
        alike: parts by their look.
    """

    def __init__(self) -> None:
        self._by_name: dict[Hashable, Part] = {}
        self.alike = AlikeParts(ALIKE_ROOM)

    def find(self, name: Hashable, key: object) -> Part | None:
        """Return the part of a name if it still looks as its key says."""
        found = self._by_name.get(name)
        return found if found is not None and found.key == key else None

    def find_at(
        self, name: Hashable, key: object, place: pygame.Rect, look: Hashable
    ) -> Part | None:
        """Return what a part looks like in a place, by its name or by its look; None if unknown."""
        found = self.find(name, key)
        if found is not None and found.place == place:
            return found
        twin = None if look is None else self.alike.get(look)
        if twin is None or twin.place.size != place.size:
            return None
        found = self._by_name[name] = twin.elsewhere(place, key)
        return found

    def keep(self, name: Hashable, part: Part, look: Hashable) -> None:
        """Keep a part under its name, and under its look if it has one."""
        self._by_name[name] = part
        if look is not None:
            self.alike.keep(look, part)

    def clear(self) -> None:
        """Keep nothing."""
        self._by_name.clear()
        self.alike.clear()


class AlikeParts:
    """Parts by their look, of at most so many bytes together: the oldest goes first.

    Args:
        room: bytes.

    Attributes:
        bytes: what all of them take.
    """

    def __init__(self, room: int) -> None:
        self._room = room
        self.bytes = 0
        self._parts: dict[Hashable, Part] = {}

    def get(self, look: Hashable) -> Part | None:
        """Return the part that looks so, or None."""
        return self._parts.get(look)

    def keep(self, look: Hashable, part: Part) -> None:
        """Keep a part, in place of the one that looks so; the newest always stays."""
        before = self._parts.pop(look, None)
        self.bytes += size_of(part.picture) - (size_of(before.picture) if before else 0)
        self._parts[look] = part
        while self.bytes > self._room and len(self._parts) > 1:
            self.bytes -= size_of(self._parts.pop(next(iter(self._parts))).picture)

    def clear(self) -> None:
        """Keep nothing."""
        self._parts.clear()
        self.bytes = 0
