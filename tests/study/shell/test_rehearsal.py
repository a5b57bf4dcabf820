"""What is rare is painted before it is seen, and nothing of that is seen."""

from __future__ import annotations

import dataclasses

import pygame
import pytest

import sample_screens as samples
from study.messages import messages_for
from study.screens import Cue, CueKind, FleetScreen, View
from study.shell.drawing import cues, lettering, maps, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.renderer import Renderer
from watched_drawing import show_until_rehearsed

pytestmark = pytest.mark.usefixtures("fonts")

SIZE = (1280, 960)
VIEWS: list[View] = ["tiles", "enlarged", "operated_only"]


def fleet(view: View) -> FleetScreen:
    screen = dataclasses.replace(samples.fleet(12), view=view)
    tiles = tuple(dataclasses.replace(tile, cue=None) for tile in screen.tiles)
    if view == "operated_only":
        tiles = tuple(tile for tile in tiles if tile.robot == screen.operated)
    return dataclasses.replace(screen, tiles=tiles)


def rehearsed(screen: FleetScreen) -> tuple[Renderer, pygame.Surface]:
    """Show a screen for as long as a rehearsal takes."""
    renderer, surface = Renderer(SIZE), pygame.Surface(SIZE)
    show_until_rehearsed(renderer, surface, screen, samples.T_NS)
    return renderer, surface


def kept_bytes(canvas: Canvas) -> int:
    return canvas.sprites.bytes + canvas._backgrounds.bytes + lettering._LINES.bytes


def show_all_cues(renderer: Renderer, surface: pygame.Surface, screen: FleetScreen) -> int:
    """Show each cue in each tile, and drive each robot; return how many bytes more are kept."""
    canvas = renderer.canvas
    before = kept_bytes(canvas)
    for number, kind in enumerate(cues.STYLES):
        for amount in (2.0, 17.0, 64.0):
            t_ns = samples.T_NS + number
            cued = tuple(
                dataclasses.replace(tile, cue=Cue(kind, amount, t_ns)) for tile in screen.tiles
            )
            renderer.draw(surface, dataclasses.replace(screen, tiles=cued), t_ns)
    for tile in screen.tiles:
        renderer.draw(surface, dataclasses.replace(screen, operated=tile.robot), samples.T_NS + 99)
    return kept_bytes(canvas) - before


@pytest.mark.parametrize("view", VIEWS)
def test_the_first_cues_find_all_painted(view: View) -> None:
    """After the first seconds no cue, however late, adds to what is kept; without them all do."""
    screen = fleet(view)
    at_once = Renderer(SIZE)
    surface = pygame.Surface(SIZE)
    at_once.draw(surface, screen, samples.T_NS)
    assert show_all_cues(at_once, surface, screen) > 100_000
    renderer, surface = rehearsed(screen)
    assert show_all_cues(renderer, surface, screen) == 0


@pytest.mark.parametrize("view", VIEWS)
def test_nothing_of_it_is_seen(view: View) -> None:
    """The picture, its texts and what is said of them are those of a screen just drawn."""
    screen = fleet(view)
    renderer, surface = rehearsed(screen)
    later = dataclasses.replace(screen, timestep=screen.timestep + 1)
    renderer.draw(surface, later, samples.T_NS)
    plain, alone = Renderer(SIZE), pygame.Surface(SIZE)
    plain.draw(alone, later, samples.T_NS)
    assert pygame.image.tobytes(surface, "RGB") == pygame.image.tobytes(alone, "RGB")
    assert renderer.overflows == plain.overflows == []


def test_a_tint_is_painted_over_the_plate_alone() -> None:
    """To the last pixel as a map with a plate of that colour, and no more maps are kept."""
    scene = samples.fleet(12).scene
    assert scene.plate is not None
    canvas = Canvas(SIZE)
    place = pygame.Rect(41, 83, 700, 525)
    maps.draw_map(canvas, scene, place, palette.FLOOR, palette.PLATE)
    kept = canvas._backgrounds.bytes
    maps.draw_map(canvas, scene, place, palette.FLOOR, palette.PLATE, palette.GREEN_TINT)
    assert canvas._backgrounds.bytes == kept > 0
    assert canvas.written == []
    painted = pygame.image.tobytes(canvas.surface, "RGB")
    maps.draw_map(canvas, scene, place, palette.FLOOR, palette.GREEN_TINT)
    assert pygame.image.tobytes(canvas.surface, "RGB") == painted
    maps.draw_map(canvas, scene, place, palette.FLOOR, palette.PLATE)
    assert pygame.image.tobytes(canvas.surface, "RGB") != painted


@pytest.mark.parametrize("kind", ["damage", "pack", "stuck"])
def test_pills_with_numbers_have_few_widths(kind: CueKind) -> None:
    """Each is a box that is kept; the number stays inside it."""
    canvas = Canvas(SIZE)
    widths = set()
    for amount in range(1, 200):
        canvas.begin()
        cue = Cue(kind, float(amount), 0)
        pill = cues.draw_pill(canvas, cue, 100, 100, 27, 400)
        widths.add(pill.width)
        (text,) = canvas.written
        assert text.text == cues.pill_text(messages_for("en"), cue)
        assert pill.contains(text.place)
        assert canvas.overflows == []
    assert 1 < len(widths) <= 5


@pytest.mark.parametrize("name", ["pause", "survey_three", "page_ready", "reveal"])
def test_a_page_in_between_leaves_no_lines(name: str) -> None:
    """A pause in the fiftieth minute takes no memory that stays; a fleet run's lines do stay."""
    screen = fleet("tiles")
    renderer, surface = rehearsed(screen)
    before = lettering._LINES.bytes
    renderer.draw(surface, samples.samples()[name], samples.T_NS)
    assert renderer.canvas.written
    assert lettering._LINES.bytes == before > 0
    renderer.draw(surface, screen, samples.T_NS)
    assert lettering._LINES.bytes == before
