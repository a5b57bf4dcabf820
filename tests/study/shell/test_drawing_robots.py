"""A robot is painted in an eighth of its headings; the others are mirrored and turned."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pygame
import pytest

from study.shell.drawing import robots
from study.shell.drawing.canvas import Canvas
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


def test_parts_that_look_alike_stay_within_their_room() -> None:
    """Rows of health have hundreds of looks; as many are kept as fit."""
    canvas = Canvas((400, 100))
    place = pygame.Rect(0, 0, 400, 100)
    for look in range(200):
        canvas.remember("row", look, place, lambda: None, alike=("look", look))
        assert canvas.parts.alike.bytes <= ALIKE_ROOM
    assert canvas.parts.alike.bytes > ALIKE_ROOM / 2
