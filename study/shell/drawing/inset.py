"""The small map in a corner of a picture: where its robot is."""

from __future__ import annotations

import pygame

from study.events.scene import Scene
from study.shell.drawing import maps, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.clips import clipped
from study.shell.drawing.grid import TilePlace
from study.shell.drawing.motion import Pose
from study.shell.drawing.robots import draw_robot

SHARE = 0.34
"""Width of the map in widths of the picture."""
MARGIN = 0.025


def place_of(scene: Scene, place: TilePlace) -> pygame.Rect:
    """Return where a tile's small map goes, pixels: at the right of the picture's foot."""
    width = round(SHARE * place.map.width)
    drawn = pygame.Rect(0, 0, width, round(width * scene.height / scene.width))
    margin = max(3, round(MARGIN * place.map.width))
    drawn.bottomright = (place.map.right - margin, place.map.bottom - margin)
    return drawn


def draw(
    canvas: Canvas, scene: Scene, place: TilePlace, pose: Pose, *, robot: int, driven: bool
) -> pygame.Rect:
    """Draw the map with the one robot on it.

    Args:
        canvas: to draw on.
        scene: the map.
        place: the tile.
        pose: where the robot is.
        robot: its index from 0.
        driven: whether the participant drives it.

    Returns:
        All that it covers, pixels.
    """
    drawn = place_of(scene, place)
    line = max(1, canvas.u(1.4))
    edged = drawn.inflate(2 * line, 2 * line)
    canvas.surface.fill(palette.INK, edged)
    maps.draw_map(canvas, scene, drawn, palette.FLOOR, palette.WALL)
    view = maps.MapView(scene, drawn)
    # Whole pixels, as in `looks.Body`: it is drawn where its tile is said to show it.
    x, y = map(round, view.robot_point(pose.x, pose.y, driven=driven))
    label = str(robot + 1) if place.single else ""
    with clipped(canvas.surface, drawn), canvas.moving():
        draw_robot(canvas, x, y, view.robot_radius, pose.heading, driven=driven, label=label)
    return edged
