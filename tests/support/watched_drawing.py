"""Draws screens and keeps all that was written, with the ground it was written on."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pygame

import sample_screens as samples
from study.messages import messages_for, pseudo
from study.screens import FleetScreen, Screen
from study.shell.drawing.drawn import Boxed, Written
from study.shell.drawing.palette import Colour
from study.shell.drawing.renderer import REHEARSED_EVERY, Renderer

WORDS = frozenset(
    {
        "heading", "message", "unit", "header_left", "header_right", "title", "subtitle",
        "next_hint", "action", "text", "prompt", "reminder", "reason",
    }
)  # fmt: skip
"""Fields of screens that hold words."""
LISTS = frozenset({"paragraphs", "labels", "keys"})
MOST_STEPS = 200
"""Of a rehearsal."""


def show_until_rehearsed(
    renderer: Renderer, surface: pygame.Surface, screen: FleetScreen, now_ns: int
) -> None:
    """Show a fleet run until all that may be seen in it has been painted."""
    for _ in range(REHEARSED_EVERY * MOST_STEPS):
        renderer.draw(surface, screen, now_ns)


def in_pseudo(value: Any) -> Any:
    """Return a screen with all its words in the pseudo-locale, as a session would give them."""
    if isinstance(value, tuple):
        return tuple(in_pseudo(item) for item in value)
    if not dataclasses.is_dataclass(value):
        return value
    changed: dict[str, Any] = {}
    for field in dataclasses.fields(value):
        given = getattr(value, field.name)
        if field.name in WORDS:
            changed[field.name] = pseudo(given) if given else ""
        elif field.name in ("paragraphs", "options"):
            changed[field.name] = tuple(pseudo(text) for text in given)
        elif field.name in LISTS:
            changed[field.name] = tuple((first, pseudo(words)) for first, words in given)
        elif field.name in ("items", "fleet"):
            changed[field.name] = in_pseudo(given)
    return dataclasses.replace(value, **changed)  # type: ignore[type-var]


@dataclasses.dataclass(frozen=True)
class Seen:
    """What was drawn, and the most frequent colours of its ground with their shares."""

    drawn: Written | Boxed
    ground: tuple[tuple[Colour, float], ...]


def ground_of(surface: pygame.Surface, place: pygame.Rect) -> tuple[tuple[Colour, float], ...]:
    """Return the colours in a place, the most frequent first, with their shares."""
    clipped = place.clip(surface.get_rect())
    if not clipped.width or not clipped.height:
        return ()
    pixels = pygame.surfarray.array3d(surface.subsurface(clipped)).reshape(-1, 3)
    packed = pixels.astype(np.int64) @ np.array([65536, 256, 1])
    values, counts = np.unique(packed, return_counts=True)
    order = np.argsort(-counts)[:8]
    return tuple(
        (
            (int(v) >> 16, int(v) >> 8 & 255, int(v) & 255),
            float(c) / len(packed),
        )
        for v, c in zip(values[order], counts[order], strict=True)
    )


def watched(
    screen: Screen, size: tuple[int, int], factor: float = 1.0, locale: str = "en"
) -> tuple[Renderer, list[Seen]]:
    """Draw a screen once at the scale that fits, and return what was drawn."""
    shown = in_pseudo(screen) if locale == "pseudo" else screen
    renderer = Renderer(size, factor, messages_for(locale))
    surface = pygame.Surface(size)
    renderer.draw(surface, shown, samples.T_NS)
    # A screen is drawn repeatedly until it fits: what counts is the last picture.
    again = Renderer(size, factor, messages_for(locale))
    again.canvas.rescale(renderer.canvas.scale)
    again._wanted = renderer.canvas.scale
    seen: list[Seen] = []
    again.canvas.watcher = lambda on, drawn: seen.append(Seen(drawn, ground_of(on, drawn.place)))
    again.draw(pygame.Surface(size), shown, samples.T_NS)
    return again, seen


def fleets() -> dict[str, FleetScreen]:
    """Return fleet screens of all sizes and views, by name."""
    found = {
        f"tiles_{robots}": samples.fleet(robots, operated=min(4, robots - 1))
        for robots in (1, 2, 4, 6, 9, 12, 20, 30, 48)
    }
    for robots in (2, 12, 48):
        found[f"enlarged_{robots}"] = dataclasses.replace(
            samples.fleet(robots, operated=1), view="enlarged"
        )
        found[f"suggested_{robots}"] = dataclasses.replace(
            samples.fleet(robots, operated=0),
            allocation="suggested",
            suggested=1,
            keys=(samples.DRIVE, ("Space", "accept"), samples.PAUSE),
        )
    found["enlarged_nobody"] = dataclasses.replace(
        samples.fleet(12, operated=-1), view="enlarged", message="Choose a robot to drive"
    )
    return found
