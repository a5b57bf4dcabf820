"""What was drawn, as records: for fitting a screen into its window, and for tests."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import pygame

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
