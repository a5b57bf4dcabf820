"""Tiles of a task that takes pictures: each shows its robot's, and only what changed is painted."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pygame
import pytest

import sample_screens as samples
from study.events.scene import Scene
from study.screens import Cue, FleetScreen, View
from study.shell.drawing import inset, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.fleet import FleetPainter
from study.shell.drawing.fleet_places import layout, tile_places
from study.shell.drawing.pictures import NO_PICTURE, Pictures
from study.shell.drawing.renderer import Renderer

pytestmark = pytest.mark.usefixtures("fonts")

SIZE = (1280, 960)
CAMERA = Scene(15.0, 10.0, (), (), None, 0.35, camera=True)
ROOMS = dataclasses.replace(samples.SCENE, camera=True)
"""Rooms that pictures are taken of."""
SMALL_MAP = dataclasses.replace(ROOMS, inset=True)


def fleet(robots: int = 4, scene: Scene = CAMERA, **changes: object) -> FleetScreen:
    """Return a fleet whose tiles show pictures."""
    shown = samples.fleet(robots, operated=1, cued=False)
    return dataclasses.replace(shown, scene=scene, **changes)  # type: ignore[arg-type]


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
    assert changed == third.map
    assert surface.get_at(third.map.center)[:3] == (99, 99, 99)


@pytest.mark.parametrize("scene", [CAMERA, SMALL_MAP])
@pytest.mark.parametrize("view", ["tiles", "enlarged"])
def test_pictures_painted_on_look_as_if_painted_anew(view: View, scene: Scene) -> None:
    """To the last pixel, whatever of pictures, robots, health and choice changes or does not."""
    chance = np.random.default_rng(3)
    pictures = Pictures()
    on, anew, screen = Canvas(SIZE), Canvas(SIZE), fleet(scene=scene, view=view)
    greys = [10, 20, 30, 40]
    painter = FleetPainter(pictures)
    pictures.take(plain(*greys))
    painter.draw(on, screen, screen.t_ns, onto=False)
    parts = 0
    for _ in range(60):
        tiles = list(screen.tiles)
        for robot in range(4):
            if chance.random() < 0.4:
                greys[robot] = int(chance.integers(255))
            if chance.random() < 0.5:
                x, y = chance.uniform(1, 9, 2)
                health = 50.0 if chance.random() < 0.2 else tiles[robot].health
                tiles[robot] = dataclasses.replace(tiles[robot], x=x, y=y, health=health)
        operated = int(chance.integers(4)) if chance.random() < 0.2 else screen.operated
        screen = dataclasses.replace(
            screen, tiles=tuple(tiles), operated=operated, t_ns=screen.t_ns + 125_000_000
        )
        pictures.take(plain(*greys))
        for later_ns in (0, 60_000_000):
            changed = painter.draw(on, screen, screen.t_ns + later_ns, onto=True)
            parts += changed is not None
            whole = FleetPainter(pictures)
            whole.motion = painter.motion.copy()
            whole.draw(anew, screen, screen.t_ns + later_ns, onto=False)
            assert pygame.image.tobytes(on.surface, "RGB") == pygame.image.tobytes(
                anew.surface, "RGB"
            )
    # Else nothing would have been compared.
    assert parts > 60


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


def drawn_with(screen: FleetScreen, *greys: int) -> tuple[Renderer, pygame.Surface]:
    """Draw a screen with pictures of these greys; without any, all are missing."""
    pictures = Pictures()
    pictures.take(plain(*greys) if greys else [])
    renderer, surface = Renderer(SIZE, pictures=pictures), pygame.Surface(SIZE)
    renderer.draw(surface, screen, samples.T_NS)
    assert not renderer.overflows
    return renderer, surface


def seen_in(surface: pygame.Surface, place: pygame.Rect) -> npt.NDArray[np.uint8]:
    """Return what is drawn in a place."""
    return pygame.surfarray.array3d(surface.subsurface(place))


def test_pictures_of_rooms_have_number_health_and_frame_beside_them() -> None:
    """Nothing lies over a picture: number and health stand above it, the blue frame around it."""
    screen = fleet(scene=ROOMS)
    renderer, surface = drawn_with(screen, 10, 20, 30, 40)
    written = [line.text for line in renderer.canvas.written]
    for tile, place, grey in zip(
        screen.tiles, tile_places(renderer.canvas, screen), (10, 20, 30, 40), strict=True
    ):
        assert str(tile.robot + 1) in written
        assert f"{tile.health:.0f}" in written
        assert not place.map.colliderect(place.plate)
        middle = place.map.inflate(-place.map.width // 3, -place.map.height // 3)
        assert (seen_in(surface, middle) == grey).all()
    driven = tile_places(renderer.canvas, screen)[screen.operated]
    beside = (driven.map.left - 4, driven.map.centery)
    assert surface.get_at(beside)[:3] == palette.BLUE


def test_a_small_map_lies_in_the_corner_of_each_picture() -> None:
    """Its corner alone differs from a tile without one, and its robot moves on it."""
    plain_tiles, mapped = fleet(scene=ROOMS), fleet(scene=SMALL_MAP)
    renderer, without = drawn_with(plain_tiles, 10, 20, 30, 40)
    _, with_map = drawn_with(mapped, 10, 20, 30, 40)
    for place in tile_places(renderer.canvas, mapped):
        differs = (seen_in(without, place.map) != seen_in(with_map, place.map)).any(axis=2)
        share = inset.SHARE + 2 * inset.MARGIN
        assert differs.any()
        assert not differs[: round(place.map.width * (1 - share))].any()
        assert not differs[:, : round(place.map.height * (1 - share)) - 4].any()
    moved = dataclasses.replace(
        mapped,
        tiles=tuple(dataclasses.replace(tile, x=tile.x / 2) for tile in mapped.tiles),
    )
    _, later = drawn_with(moved, 10, 20, 30, 40)
    first = tile_places(renderer.canvas, mapped)[0].map
    assert (seen_in(later, first) != seen_in(with_map, first)).any()


def test_where_pictures_of_rooms_are_missing_the_map_is_drawn() -> None:
    """A replay without the engine shows the rooms from above, and the robots in them."""
    screen = fleet(scene=ROOMS)
    renderer, surface = drawn_with(screen)
    written = " ".join(line.text for line in renderer.canvas.written)
    assert NO_PICTURE not in written
    for place in tile_places(renderer.canvas, screen):
        assert len(np.unique(seen_in(surface, place.map).reshape(-1, 3), axis=0)) > 20


def test_pictures_on_the_way_of_a_timestep_follow_each_other() -> None:
    """Of four pictures a timestep, each is shown for a quarter of it, the last from then on."""
    pictures = Pictures()
    pictures.take(np.stack([plain(10, 20, 30, 40)] * 4, axis=1))
    ways = np.stack([plain(*[k] * 4) for k in (50, 60, 70, 80)], axis=1)
    pictures.take(ways)
    renderer, surface, screen = Renderer(SIZE, pictures=pictures), pygame.Surface(SIZE), fleet()
    quarter = round(screen.timestep_seconds * 1e9 / 4)
    seen = []
    for passed in (0, 1, 2, 3, 9):
        renderer.draw(surface, screen, screen.t_ns + passed * quarter + 1000)
        middle = tile_places(renderer.canvas, screen)[2].map.center
        seen.append(surface.get_at(middle)[0])
    assert seen == [50, 60, 70, 80, 80]


@pytest.mark.parametrize("scene", [ROOMS, SMALL_MAP, samples.SCENE, CAMERA])
def test_a_robot_that_is_held_is_dimmed_and_marked(scene: Scene) -> None:
    """Its tile says that it waits and is paler; the others stay as they are."""
    screen = dataclasses.replace(fleet(), scene=scene)
    held = dataclasses.replace(screen.tiles[2], cue=Cue("held", 0.0, samples.T_NS))
    standing = dataclasses.replace(screen, tiles=(*screen.tiles[:2], held, *screen.tiles[3:]))
    renderer, usual = drawn_with(screen, 10, 20, 30, 40)
    marked_renderer, marked = drawn_with(standing, 10, 20, 30, 40)
    assert "WAITS" in [line.text for line in marked_renderer.canvas.written]
    for number, place in enumerate(tile_places(renderer.canvas, screen)):
        corner = pygame.Rect(place.map.topleft, (place.map.width // 4, place.map.height // 4))
        before, after = seen_in(usual, corner), seen_in(marked, corner)
        if number == 2:
            assert (
                np.abs(after - np.array(palette.PAGE, float)).mean()
                <= np.abs(before - np.array(palette.PAGE, float)).mean()
            )
        else:
            assert (before == after).all()
    third = tile_places(renderer.canvas, screen)[2].map
    assert (seen_in(usual, third) != seen_in(marked, third)).any(axis=2).mean() > 0.5
