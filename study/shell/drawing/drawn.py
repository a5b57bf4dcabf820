"""What was drawn, as records: for fitting a screen into its window, and for tests."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable

import pygame

from study.shell.drawing.kept import size_of
from study.shell.drawing.palette import Colour


@dataclasses.dataclass(frozen=True, slots=True)
class Written:
    """A line of text that was written.

    Attributes:
        text: the line.
        place: its width, and the height of its capitals, pixels.
        colour: of the text.
        moving: whether it belongs to a map and what moves there, where things may meet.
    """

    text: str
    place: pygame.Rect
    colour: Colour
    moving: bool


@dataclasses.dataclass(frozen=True, slots=True)
class Boxed:
    """A box that was drawn: its outer edge in pixels, its colours, and whether it moves."""

    place: pygame.Rect
    fill: Colour
    edge: Colour | None
    moving: bool


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


Watcher = Callable[[pygame.Surface, Written | Boxed], None]
"""Told of each text and box just before it is drawn, with the surface as it is then."""


def is_crowded(size: tuple[int, int], written: list[Written], boxes: list[pygame.Rect]) -> bool:
    """Return whether anything still lies on a text, reaches over a box's edge or off the screen.

    Args:
        size: of the screen, pixels.
        written: all texts.
        boxes: those that do not move.
    """
    bounds = pygame.Rect((0, 0), size)
    if not all(bounds.contains(box) for box in boxes):
        return True
    places = [text.place for text in written if not text.moving]
    if any(place.collidelistall(places) != [index] for index, place in enumerate(places)):
        return True
    return any(
        not boxes[index].contains(place)
        for place in places
        for index in place.collidelistall(boxes)
    )


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
