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
from study.messages import Messages
from study.screens import Cue
from study.shell.drawing import cues
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.looks import TileView
from study.shell.drawing.tile import draw_tile

AMOUNTS = (1.0, 8.0, 18.0, 88.0, 188.0)
"""Health points and seconds that are written in one, two and three digits."""


def rehearsal(
    canvas: Canvas, scene: Scene, views: Iterable[TileView], shown_cues: Iterable[Cue | None]
) -> Iterator[None]:
    """Draw tiles with each of some cues, one with each step, where nobody sees it.

    Args:
        canvas: that keeps what is painted.
        scene: the map.
        views: the tiles.
        shown_cues: what each of them shows in turn.
    """
    # All shapes are painted, and there is no room to put any: that takes most of a tile's time.
    nowhere = pygame.Surface((0, 0))
    for shown, cue in itertools.product(views, shown_cues):
        tile = dataclasses.replace(shown.tile, cue=cue)
        overflows = len(canvas.overflows)
        with canvas.aside(nowhere):
            draw_tile(canvas, scene, dataclasses.replace(shown, tile=tile))
        del canvas.overflows[overflows:]
        yield


def all_cues(messages: Messages) -> Iterator[Cue]:
    """Yield cues of all kinds; where an amount is written, with some of one to three digits.

    Args:
        messages: the texts of the participant's language.
    """
    for kind in cues.STYLES:
        # The sign of what is written follows from the kind.
        with_amounts = [Cue(kind, amount, 0) for amount in AMOUNTS]
        yield from {cues.pill_text(messages, cue): cue for cue in with_amounts}.values()
