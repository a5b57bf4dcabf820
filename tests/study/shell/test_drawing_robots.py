"""A robot is painted in an eighth of its headings; the others are mirrored and turned."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt
import pygame
import pytest

import sample_screens as samples
from study.screens import Cue, CueKind
from study.shell.drawing import palette, robots
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.fleet import FleetPainter
from study.shell.drawing.fleet_places import tile_places
from study.shell.drawing.parts import ALIKE_ROOM
from study.shell.drawing.robots import HEADING_STEPS, draw_robot

SIDE, RADIUS = 140, 18.0


def drawn(canvas: Canvas, step: int, *, driven: bool) -> npt.NDArray[np.int64]:
    """Return a robot in the middle of a white square, int [x, y, 3]."""
    canvas.surface.fill("white")
    heading = 2 * math.pi * step / HEADING_STEPS
    draw_robot(canvas, SIDE / 2, SIDE / 2, RADIUS, heading, driven=driven)
    return pygame.surfarray.array3d(canvas.surface).astype(np.int64)


@pytest.mark.parametrize("driven", [True, False])
def test_every_heading_looks_as_if_painted(monkeypatch: pytest.MonkeyPatch, driven: bool) -> None:
    """But for single pixels at edges, as polygons are filled from one side."""
    turned, painted = Canvas((SIDE, SIDE)), Canvas((SIDE, SIDE))
    pictures = [drawn(turned, step, driven=driven) for step in range(HEADING_STEPS)]
    monkeypatch.setattr(robots, "_within_an_eighth", lambda step: (step, False, 0))
    for step, picture in enumerate(pictures):
        wanted = drawn(painted, step, driven=driven)
        apart = np.abs(picture - wanted).sum(axis=2)
        assert (apart > 200).sum() < 40, step
        # Of another heading far more differs: else nothing would have been compared.
        other = drawn(painted, step + 5, driven=driven)
        assert (np.abs(picture - other).sum(axis=2) > 200).sum() > 80, step


@pytest.mark.parametrize("driven", [True, False])
def test_all_headings_take_little_room(driven: bool) -> None:
    """A session in which every heading is seen takes no more than its first minutes."""
    canvas = Canvas((SIDE, SIDE))
    drawn(canvas, 0, driven=driven)
    one = canvas.sprites.bytes
    for step in range(HEADING_STEPS):
        drawn(canvas, step, driven=driven)
    assert canvas.sprites.bytes <= 24 * one


@pytest.mark.parametrize("kind", ["stuck", "damage", None])
@pytest.mark.parametrize("driven", [True, False])
def test_rings_end_at_the_outer_wall(kind: CueKind | None, driven: bool) -> None:
    """What lies round a robot at the map's edge covers no part of the wall there."""
    pygame.font.init()
    screen = samples.fleet(4, operated=0 if driven else 1)
    cue = None if kind is None else Cue(kind, 7.0, samples.T_NS)
    first = dataclasses.replace(screen.tiles[0], x=0.2, y=3.0, heading=0.0, cue=cue)
    screen = dataclasses.replace(screen, tiles=(first, *screen.tiles[1:]))
    canvas = Canvas((1280, 720))
    FleetPainter().draw(canvas, screen, screen.t_ns, onto=False)
    drawn = tile_places(canvas, screen)[0].map
    x, top = drawn.left + 1, drawn.top + round(0.6 * drawn.height)
    column = {canvas.surface.get_at((x, y))[:3] for y in range(top, drawn.bottom)}
    assert column == {palette.WALL}


def test_parts_that_look_alike_stay_within_their_room() -> None:
    """Rows of health have hundreds of looks; as many are kept as fit."""
    canvas = Canvas((400, 100))
    place = pygame.Rect(0, 0, 400, 100)
    for look in range(200):
        canvas.remember("row", look, place, lambda: None, alike=("look", look))
        assert canvas.parts.alike.bytes <= ALIKE_ROOM
    assert canvas.parts.alike.bytes > ALIKE_ROOM / 2
