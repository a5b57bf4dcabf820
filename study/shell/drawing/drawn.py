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


@dataclasses.dataclass(frozen=True, slots=True)
class Part:
    """A part of the screen that was painted: where, what its look depends on, and its texts."""

    place: pygame.Rect
    key: object
    picture: pygame.Surface
    written: tuple[Written, ...]
    boxed: tuple[pygame.Rect, ...]


Watcher = Callable[[pygame.Surface, Written | Boxed], None]
"""Told of each text and box just before it is drawn, with the surface as it is then."""
