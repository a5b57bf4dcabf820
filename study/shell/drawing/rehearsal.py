"""Painting what is rare before it is seen.

A goal may be reached in the tenth minute for the first time. All that is painted only then takes
time at a moment that matters, and memory that had seemed settled.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Iterator

import pygame

from study.events.scene import Scene
from study.screens import Cue
from study.shell.drawing import cues
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.clips import clipped
from study.shell.drawing.looks import TileView
from study.shell.drawing.tile import draw_tile

AMOUNTS = (1.0, 8.0, 18.0, 88.0, 188.0)
"""Health points and seconds that are written in one, two and three digits."""
WITH_AMOUNTS = ("damage", "pack", "stuck")


def rehearsal(
    canvas: Canvas,
    surface: pygame.Surface,
    scene: Scene,
    views: Iterable[TileView],
    shown_cues: Iterable[Cue | None],
) -> Iterator[None]:
    """Draw tiles with each of some cues, one with each step, where nobody sees it.

    Args:
        canvas: that keeps what is painted.
        surface: of the canvas's size, that nobody sees.
        scene: the map.
        views: the tiles.
        shown_cues: what each of them shows in turn.
    """
    for shown, cue in itertools.product(views, list(shown_cues)):
        tile = dataclasses.replace(shown.tile, cue=cue)
        overflows = len(canvas.overflows)
        # All shapes are painted, and none is put anywhere: that takes most of a tile's time.
        with canvas.aside(surface), clipped(surface, pygame.Rect(0, 0, 0, 0)):
            draw_tile(canvas, scene, dataclasses.replace(shown, tile=tile))
        del canvas.overflows[overflows:]
        yield


def all_cues() -> Iterator[Cue]:
    """Yield cues of all kinds, with amounts of one, two and three digits."""
    for kind in cues.STYLES:
        for amount in AMOUNTS if kind in WITH_AMOUNTS else AMOUNTS[:1]:
            # The sign of what is written follows from the kind.
            yield Cue(kind, amount, 0)
