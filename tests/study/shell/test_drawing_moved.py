"""What is painted picture by picture looks as if all of it had been painted anew."""

from __future__ import annotations

import dataclasses
import random

import pygame
import pytest

import sample_screens as samples
from study.screens import Cue, FleetScreen, Tile, View
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.fleet import FleetPainter

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


@pytest.mark.parametrize("has_health", [True, False])
@pytest.mark.parametrize(("robots", "view"), [(12, "tiles"), (48, "tiles"), (6, "enlarged")])
def test_pictures_painted_on_look_as_if_painted_anew(
    robots: int, view: View, has_health: bool
) -> None:
    """To the last pixel, after moves, switches, cues and ends of episodes."""
    pygame.font.init()
    chance = random.Random(robots)
    screen = dataclasses.replace(samples.fleet(robots), view=view, has_health=has_health)
    size = (1280, 960)
    on, anew = Canvas(size), Canvas(size)
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
