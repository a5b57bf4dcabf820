"""What is painted picture by picture looks as if all of it had been painted anew."""

from __future__ import annotations

import dataclasses
import random

import pygame
import pytest

import sample_screens as samples
from study.messages import messages_for
from study.screens import Cue, FleetScreen, Tile, View
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.drawn import Boxed, Written
from study.shell.drawing.fleet import FleetPainter
from study.shell.drawing.fleet_places import layout
from study.shell.drawing.maps import MapView
from study.shell.drawing.renderer import Renderer

STEP_NS = 125_000_000
FRAMES_A_STEP = 4


def moved(tile: Tile, chance: random.Random, t_ns: int) -> Tile:
    """Return a robot a timestep later, now and then with another health or cue."""
    cue = tile.cue
    if chance.random() < 0.1:
        kinds = ("damage", "pack", "goal", "stuck", "low", "lost", "held")
        kind = chance.choice(kinds)
        cue = chance.choice([None, Cue(kind, chance.uniform(-9, 9), t_ns)])  # type: ignore[arg-type]
    return dataclasses.replace(
        tile,
        x=min(19.8, max(0.2, tile.x + chance.uniform(-0.5, 0.5))),
        y=min(14.8, max(0.2, tile.y + chance.uniform(-0.5, 0.5))),
        heading=tile.heading + chance.uniform(-0.4, 0.4),
        health=chance.uniform(0, 100) if chance.random() < 0.1 else tile.health,
        cue=cue,
        episode=tile.episode + (chance.random() < 0.02),
    )


def later(screen: FleetScreen, chance: random.Random) -> FleetScreen:
    """Return what a screen is a timestep later."""
    t_ns = screen.t_ns + STEP_NS
    switched = chance.random() < 0.15
    return dataclasses.replace(
        screen,
        timestep=screen.timestep + 1,
        t_ns=t_ns,
        timestep_seconds=STEP_NS / 1e9,
        tiles=tuple(moved(tile, chance, t_ns) for tile in screen.tiles),
        operated=chance.randrange(screen.robots) if switched else screen.operated,
        switched_ns=t_ns if switched else screen.switched_ns,
        suggested=chance.choice([-1, 0, 1]) if chance.random() < 0.1 else screen.suggested,
    )


LOOKS: list[tuple[int, View, tuple[int, int], float]] = [
    (12, "tiles", (1280, 960), 1.0),
    (48, "tiles", (1280, 960), 1.0),
    (6, "enlarged", (1280, 960), 1.0),
    (12, "enlarged", (1280, 720), 1.5),
    (12, "enlarged", (1280, 720), 2.0),
]


@pytest.mark.parametrize("has_health", [True, False])
@pytest.mark.parametrize(("robots", "view", "size", "factor"), LOOKS)
def test_pictures_painted_on_look_as_if_painted_anew(
    robots: int, view: View, size: tuple[int, int], factor: float, has_health: bool
) -> None:
    """To the last pixel, after moves, switches, cues and ends of episodes."""
    pygame.font.init()
    chance = random.Random(robots)
    screen = dataclasses.replace(samples.fleet(robots), view=view, has_health=has_health)
    on, anew = Canvas(size), Canvas(size)
    for canvas in (on, anew):
        canvas.rescale(scale_of(screen, size, factor))
    painter = FleetPainter()
    painter.draw(on, screen, screen.t_ns, onto=False)
    parts = 0
    for _ in range(40):
        screen = later(screen, chance)
        for frame in range(FRAMES_A_STEP):
            now_ns = screen.t_ns + frame * STEP_NS // FRAMES_A_STEP
            changed = painter.draw(on, screen, now_ns, onto=True)
            parts += changed is not None
            whole = FleetPainter()
            whole.motion = painter.motion.copy()
            whole.draw(anew, screen, now_ns, onto=False)
            assert pygame.image.tobytes(on.surface, "RGB") == pygame.image.tobytes(
                anew.surface, "RGB"
            )
    # Else nothing would have been compared.
    assert parts > 100


def scale_of(screen: FleetScreen, size: tuple[int, int], factor: float) -> float:
    """Return the scale at which a screen fits its window."""
    renderer = Renderer(size, factor)
    renderer.draw(pygame.Surface(size), screen, screen.t_ns)
    return renderer.canvas.scale


@pytest.mark.parametrize("locale", ["en", "pseudo"])
@pytest.mark.parametrize("factor", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("robots", [2, 12, 48])
def test_the_name_of_the_robot_switched_to_lies_in_its_map(
    robots: int, factor: float, locale: str
) -> None:
    """Whole, off the robot, and at every scale; wherever the robot is."""
    pygame.font.init()
    size = (1280, 720)
    screen = dataclasses.replace(
        samples.fleet(robots, operated=robots - 1), view="enlarged", switched_ns=samples.T_NS
    )
    renderer = Renderer(size, factor, messages_for(locale))
    surface = pygame.Surface(size)
    for x, y in ((1.0, 1.0), (19.0, 1.0), (19.0, 14.0), (10.0, 7.5), (3.0, 7.0), (12.0, 12.0)):
        tiles = tuple(dataclasses.replace(tile, x=x, y=y) for tile in screen.tiles)
        shown = dataclasses.replace(screen, tiles=tiles)
        renderer.draw(surface, shown, samples.T_NS)
        drawn: list[Written | Boxed] = []
        renderer.canvas.watcher = lambda _on, one: drawn.append(one)  # noqa: B023
        again = pygame.Surface(size)
        renderer.draw(again, shown, samples.T_NS)
        renderer.canvas.watcher = None
        large = layout(renderer.canvas, shown).large
        assert large is not None
        named = [one for one in drawn if isinstance(one, Boxed) and one.moving][-1].place
        inside = [
            one for one in drawn
            if isinstance(one, Written) and one.moving and named.collidepoint(one.place.center)
        ]  # fmt: skip
        words = " ".join(one.text for one in inside)
        number = shown.operated + 1
        assert words == messages_for(locale).say("Switched to robot {number}", number=number)
        assert all(named.contains(one.place) for one in inside)
        assert large.map.contains(named)
        at = MapView(shown.scene, large.map).robot_point(x, y, driven=True)
        assert not named.collidepoint(at)
