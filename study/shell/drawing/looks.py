"""All that a tile's look depends on: tiles whose looks are equal look the same."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

from study.events.scene import Scene
from study.screens import Tile
from study.shell.drawing import inset, maps, palette, plate
from study.shell.drawing.grid import TilePlace
from study.shell.drawing.motion import Pose, along_trail
from study.shell.drawing.palette import Colour
from study.shell.drawing.pictures import Shot
from study.shell.drawing.plate import PlateLook
from study.shell.drawing.robots import heading_step

TRAIL_DISTANCES = (2.5, 3.6, 4.7)
"""Distances of the trail's dots behind a robot, in radii of its body."""
RING_STEPS = 120


@dataclasses.dataclass(frozen=True, slots=True)
class TileView:
    """A tile as it is at one moment.

    Attributes:
        place: where it is.
        tile: the robot's state.
        look: what stands still in it.
        pose: where its robot is drawn.
        landing: share that has passed of marking that control came here, 0 to 1; -1 for none.
        dwell_left: share of the dwell left to be shown here; -1 for none.
        ground: colour around the tile.
        shot: the robot's picture, where the task takes pictures.
    """

    place: TilePlace
    tile: Tile
    look: PlateLook
    pose: Pose
    landing: float = -1.0
    dwell_left: float = -1.0
    ground: Colour = palette.PAGE
    shot: Shot | None = None


class Body(NamedTuple):
    """All that the look of a tile's robot depends on. Two that are equal look the same.

    Attributes:
        x, y: its middle, pixels.
        trail: dots behind a robot that drives itself, pixels.
        heading: steps of turns.
        ring: steps of the dwell left, or -1.
        landing: as in `TileView`.
    """

    x: int
    y: int
    trail: tuple[tuple[int, int], ...]
    heading: int
    ring: int
    landing: float


NOWHERE = Body(0, 0, (), 0, -1, -1.0)
"""Of a robot that is not drawn."""


class Looks(NamedTuple):
    """All that the look of a tile depends on. Two that are equal look the same.

    Attributes:
        still: of what stands still, but for the health.
        health: of its row.
        body: of the robot.
        shot: number of its picture; -1 if it has none.
    """

    still: object
    health: tuple[object, ...]
    body: Body
    shot: int = -1


def looks_of(scene: Scene, shown: TileView) -> Looks:
    """Return all that the look of a tile depends on."""
    tile, place, look = shown.tile, shown.place, shown.look
    cue = None if tile.cue is None else (tile.cue.kind, round(tile.cue.amount, 1))
    if tile.cue is not None and tile.cue.kind == "stuck":
        cue = (tile.cue.kind, round(tile.cue.amount))
    lost = cue if tile.cue is not None and tile.cue.kind == "damage" else None
    ground = plate.plate_colour(place, tile, look)
    return Looks(
        still=(scene, place, cue, look, has_picture(scene, shown)),
        health=(
            place,
            ground,
            look.driven,
            round(tile.health),
            tile.health < plate.LOW_HEALTH,
            lost,
        ),
        body=_body_of(scene, shown),
        shot=-1 if shown.shot is None else shown.shot.number,
    )


def has_picture(scene: Scene, shown: TileView) -> bool:
    """Whether a picture is shown; where one is missing, a map takes its place if there is one."""
    there = shown.shot is not None and shown.shot.pixels is not None
    return scene.pictures_only or (scene.camera and there)


def _body_of(scene: Scene, shown: TileView) -> Body:
    """Return where and how a tile's robot is drawn."""
    pose, driven = shown.pose, shown.look.driven
    if has_picture(scene, shown):
        if not scene.inset:
            return NOWHERE
        view = maps.MapView(scene, inset.place_of(scene, shown.place))
        x, y = view.robot_point(pose.x, pose.y, driven=driven)
        return Body(round(x), round(y), (), heading_step(pose.heading), -1, -1.0)
    view = maps.MapView(scene, shown.place.map)
    x, y = view.robot_point(pose.x, pose.y, driven=driven)
    trail: tuple[tuple[int, int], ...] = ()
    if not driven:
        radius = view.robot_radius / view.scale
        dots = along_trail(pose.trail, tuple(radius * distance for distance in TRAIL_DISTANCES))
        points = (view.point(*dot) for dot in dots)
        trail = tuple((round(across), round(down)) for across, down in points)
    ring = round(shown.dwell_left * RING_STEPS) if shown.dwell_left >= 0 else -1
    return Body(round(x), round(y), trail, heading_step(pose.heading), ring, shown.landing)
