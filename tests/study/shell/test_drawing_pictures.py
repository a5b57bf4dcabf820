"""Tiles of a task that takes pictures: each shows its robot's, and only what changed is painted."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pygame
import pytest

import sample_screens as samples
from study.events.scene import Scene
from study.screens import FleetScreen
from study.shell.drawing.fleet import layout, tile_places
from study.shell.drawing.pictures import NO_PICTURE, Pictures
from study.shell.drawing.renderer import Renderer

SIZE = (1280, 960)
CAMERA = Scene(15.0, 10.0, (), (), None, 0.35, camera=True)


@pytest.fixture(autouse=True)
def fonts() -> None:
    """Fonts without a window."""
    pygame.font.init()


def fleet(robots: int = 4, **changes: object) -> FleetScreen:
    """Return a fleet whose tiles show pictures."""
    shown = samples.fleet(robots, operated=1, cued=False)
    return dataclasses.replace(shown, scene=CAMERA, **changes)  # type: ignore[arg-type]


def plain(*greys: int) -> npt.NDArray[np.uint8]:
    """Return a picture of one colour a robot, 300 x 200."""
    return np.stack([np.full((200, 300, 3), grey, np.uint8) for grey in greys])


def test_every_tile_shows_its_robot_s_picture() -> None:
    """All of a map's place is the picture, with nothing drawn upon it."""
    pictures = Pictures()
    pictures.take(plain(10, 20, 30, 40))
    renderer, surface, screen = Renderer(SIZE, pictures=pictures), pygame.Surface(SIZE), fleet()
    renderer.draw(surface, screen, samples.T_NS)
    assert not renderer.overflows
    for place, grey in zip(tile_places(renderer.canvas, screen), (10, 20, 30, 40), strict=True):
        seen = pygame.surfarray.array3d(surface.subsurface(place.map.inflate(-4, -4)))
        assert (seen == grey).all()


def test_a_picture_keeps_its_shape_and_colours() -> None:
    """Left is left, red is red; a picture of another shape stands in the middle."""
    pixels = np.zeros((200, 200, 3), np.uint8)
    pixels[:, :100] = (250, 0, 0)
    pixels[:, 100:] = (0, 0, 250)
    pictures = Pictures()
    pictures.take([pixels, None])
    renderer, surface, screen = Renderer(SIZE, pictures=pictures), pygame.Surface(SIZE), fleet(2)
    renderer.draw(surface, screen, samples.T_NS)
    drawn = tile_places(renderer.canvas, screen)[0].map
    quarter = drawn.height // 4
    assert surface.get_at((drawn.centerx - quarter, drawn.centery))[:3] == (250, 0, 0)
    assert surface.get_at((drawn.centerx + quarter, drawn.centery))[:3] == (0, 0, 250)
    assert surface.get_at((drawn.left + 3, drawn.centery))[:3] not in {(250, 0, 0), (0, 0, 250)}


def test_only_a_changed_picture_is_painted_anew() -> None:
    """The same picture again, or that of another robot, costs a tile nothing."""
    pictures = Pictures()
    renderer, surface, screen = Renderer(SIZE, pictures=pictures), pygame.Surface(SIZE), fleet()
    pictures.take(plain(10, 20, 30, 40))
    for _ in range(2):
        renderer.draw(surface, screen, samples.T_NS)
    pictures.take(plain(10, 20, 30, 40))
    assert renderer.draw(surface, screen, samples.T_NS) == []
    pictures.take(plain(10, 20, 99, 40))
    (changed,) = renderer.draw(surface, screen, samples.T_NS) or []
    third = tile_places(renderer.canvas, screen)[2]
    assert changed.contains(third.body)
    assert surface.get_at(third.map.center)[:3] == (99, 99, 99)


@pytest.mark.parametrize("robots", [2, 3, 4])
def test_a_line_of_guidance_stays_whole_over_new_pictures(robots: int) -> None:
    """Pictures that come while nobody is driven leave the line as it was first drawn."""
    pictures = Pictures()
    renderer, surface = Renderer(SIZE, pictures=pictures), pygame.Surface(SIZE)
    arena = dataclasses.replace(CAMERA, width=4.0, height=3.0)
    nobody = fleet(robots, operated=-1, message="Choose a robot to drive")
    nobody = dataclasses.replace(nobody, scene=arena)
    middle = layout(renderer.canvas, nobody).message
    seen = []
    for grey in (10, 200):
        pictures.take(plain(*[grey] * robots))
        renderer.draw(surface, nobody, samples.T_NS)
        line = surface.subsurface(pygame.Rect(SIZE[0] // 2 - 100, middle - 8, 200, 16))
        seen.append(line.copy().get_buffer().raw)
    assert seen[0] == seen[1]


def test_a_missing_picture_is_said_in_words() -> None:
    """A tile without a picture says so; nothing of a map, a robot or its health is drawn."""
    renderer, surface, screen = Renderer(SIZE), pygame.Surface(SIZE), fleet()
    renderer.draw(surface, screen, samples.T_NS)
    written = [line.text for line in renderer.canvas.written]
    assert sum(NO_PICTURE.startswith(text) for text in written if text) >= 4
    assert "100" not in written
    assert not renderer.overflows


def test_other_tasks_are_drawn_as_before() -> None:
    """Pictures that somebody takes change nothing where the scene is a map."""
    drawn = []
    for greys in ((), (10, 20, 30, 40)):
        pictures = Pictures()
        pictures.take(plain(*greys) if greys else [])
        surface = pygame.Surface(SIZE)
        Renderer(SIZE, pictures=pictures).draw(surface, samples.fleet(4), samples.T_NS)
        drawn.append(pygame.image.tobytes(surface, "RGB"))
    assert drawn[0] == drawn[1]
