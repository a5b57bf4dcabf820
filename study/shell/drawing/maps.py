"""A task's map as pixels: rooms, hazards, walls, packs, start and goal."""

from __future__ import annotations

import functools
import math

import pygame

from study.events.scene import DiscMark, GateMark, RectangleMark, Scene
from study.shell.drawing import marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.clips import clipped
from study.shell.drawing.grid import plate_on
from study.shell.drawing.palette import Colour

DRIVEN_REACH = 1.6
"""Distance of a driven robot's middle from the map's edge, in radii: its dart stays in sight."""


class MapView:
    """Turns metres into pixels.

    Args:
        scene: the map.
        place: where it is drawn, pixels.

    Attributes:
        scale: pixels to a metre.
        robot_radius: of a drawn robot, pixels: its own, but never too small to see.
    """

    __slots__ = ("_bottom", "_down", "_left", "place", "robot_radius", "scale", "scene")

    def __init__(self, scene: Scene, place: pygame.Rect) -> None:
        width = place.width
        self.scene = scene
        self.place = place
        self.scale: float = width / scene.width
        visible = min(0.0375 * width, 18 + 0.011 * width)
        self.robot_radius = max(scene.robot_radius * self.scale, visible, 6.0)
        self._left, self._bottom = place.left, place.bottom
        self._down = place.height / scene.height

    def point(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the map is drawn."""
        return self._left + x * self.scale, self._bottom - y * self._down

    def rectangle(self, mark: RectangleMark) -> pygame.Rect:
        """Return where a rectangle is drawn, snapped to pixels."""
        left, bottom = self.point(mark.x, mark.y)
        right, top = self.point(mark.x + mark.width, mark.y + mark.height)
        return pygame.Rect(
            round(left), round(top), round(right) - round(left), round(bottom) - round(top)
        )

    def robot_point(self, x: float, y: float, *, driven: bool) -> tuple[float, float]:
        """Return where a robot is drawn: moved inwards where edge or plate would cut its body off.

        Bodies are drawn larger than they are, so that those at an outer wall would reach beyond it.
        """
        reach = self.robot_radius * (DRIVEN_REACH if driven else 1.0) + _wall_width(
            self.place.width
        )
        across, down = self._clear_of_plate(*self.point(x, y), reach)
        return (
            min(max(across, self.place.left + reach), self.place.right - reach),
            min(max(down, self.place.top + reach), self.place.bottom - reach),
        )

    def _clear_of_plate(self, across: float, down: float, reach: float) -> tuple[float, float]:
        """Return a point moved straight away from the plate until it is out of its reach."""
        if self.scene.plate is None:
            return across, down
        x, y, width, height = self.scene.plate
        left, bottom = self.point(x, y)
        right, top = self.point(x + width, y + height)
        near_x, near_y = min(max(across, left), right), min(max(down, top), bottom)
        apart = math.hypot(across - near_x, down - near_y)
        if not 0 < apart < reach:
            return across, down
        share = reach / apart
        return near_x + (across - near_x) * share, near_y + (down - near_y) * share


def draw_map(
    canvas: Canvas,
    scene: Scene,
    place: pygame.Rect,
    floor: Colour,
    plate: Colour,
    tint: Colour | None = None,
) -> None:
    """Draw the map without robots.

    It is painted once for each size, floor and plate. A tint is painted over the plate: a map of
    its own for each would take megabytes, and those of cues that are rare come late.
    """
    whole = pygame.Rect((0, 0), place.size)
    picture = canvas.background(
        ("map", scene, place.size, floor, plate),
        place.size,
        lambda: _paint(canvas, scene, whole, floor, plate),
    )
    canvas.surface.blit(picture, place)
    if scene.plate is None or tint is None or tint == plate:
        return
    with clipped(canvas.surface, plate_on(scene, place, 0)), canvas.aside(canvas.surface):
        _paint(canvas, scene, place, floor, tint)


def _paint(canvas: Canvas, scene: Scene, place: pygame.Rect, floor: Colour, plate: Colour) -> None:
    view = MapView(scene, place)
    canvas.surface.fill(floor if scene.plate is None else plate, place)
    order = ("room", "hazard", "wall")
    for mark in sorted(scene.rectangles, key=lambda mark: order.index(mark.role)):
        drawn = view.rectangle(mark)
        if mark.role == "room":
            canvas.surface.fill(floor, drawn)
        elif mark.role == "hazard":
            marks.hatch(canvas, drawn, max(7.0, 0.031 * place.width))
        else:
            canvas.surface.fill(palette.WALL, _thickened(drawn, place.width, place))
    if scene.gates:
        _draw_finish(canvas, view, scene.gates[-1])
    for disc in scene.discs:
        draw_disc(canvas, view, disc)


def _draw_finish(canvas: Canvas, view: MapView, gate: GateMark) -> None:
    """Draw the finish line: two rows of a chequerboard."""
    x, y = view.point(gate.inner_x, gate.inner_y)
    to_x, to_y = view.point(gate.outer_x, gate.outer_y)
    size = max(3.0, 0.014 * view.place.width)
    length = math.hypot(to_x - x, to_y - y)
    squares = max(2, round(length / size))
    along_x, along_y = (to_x - x) / squares, (to_y - y) / squares
    aside_x, aside_y = -along_y, along_x
    for square in range(squares):
        for row in (0, 1):
            left, top = x + square * along_x, y + square * along_y
            left, top = left + (row - 1) * aside_x, top + (row - 1) * aside_y
            corners = (
                (left, top),
                (left + along_x, top + along_y),
                (left + along_x + aside_x, top + along_y + aside_y),
                (left + aside_x, top + aside_y),
            )
            dark = (square + row) % 2 == 0
            pygame.draw.polygon(canvas.surface, palette.WALL if dark else palette.CARD, corners)


def _wall_width(width: int) -> int:
    """Return how wide a wall at least is on a map of a width, pixels."""
    return max(2, round(0.0125 * width))


def _thickened(wall: pygame.Rect, width: int, place: pygame.Rect) -> pygame.Rect:
    """Return a wall no thinner than can be seen, moved inside the map."""
    least = _wall_width(width)
    thick = wall.inflate(max(0, least - wall.width), max(0, least - wall.height))
    return thick.clamp(place) if place.contains(thick.clamp(place)) else thick.clip(place)


@functools.lru_cache(maxsize=8)
def _outer_walls(scene: Scene) -> tuple[RectangleMark, ...]:
    """Return the walls that run along the edges of a map."""
    return tuple(
        wall
        for wall in scene.rectangles
        if wall.role == "wall"
        and (
            (wall.height > wall.width and (wall.x <= 0 or wall.x + wall.width >= scene.width))
            or (wall.width > wall.height and (wall.y <= 0 or wall.y + wall.height >= scene.height))
        )
    )


def draw_outer_walls(canvas: Canvas, view: MapView) -> None:
    """Draw the walls along a map's edges again, over what reaches beyond them."""
    for wall in _outer_walls(view.scene):
        shown = _thickened(view.rectangle(wall), view.place.width, view.place)
        canvas.surface.fill(palette.WALL, shown)


def disc_radius(view: MapView, disc: DiscMark) -> float:
    """Return the radius at which a disc is drawn, pixels."""
    if disc.role == "wall":
        return disc.radius * view.scale
    least = 0.058 if disc.role == "goal" else 0.04
    return max(disc.radius * view.scale if disc.role == "goal" else 0.0, least * view.place.width)


def draw_disc(canvas: Canvas, view: MapView, disc: DiscMark) -> None:
    """Draw a goal, a health pack, the start or a round obstacle."""
    x, y = view.point(disc.x, disc.y)
    radius = disc_radius(view, disc)
    line = max(1.2, 0.004 * view.place.width)
    if disc.role == "goal":
        marks.ring(canvas, x, y, radius, line, palette.SECONDARY, fill=palette.FLOOR)
        marks.flag(canvas, x + radius * 0.06, y, radius * 1.15)
    elif disc.role == "wall":
        marks.disc(canvas, x, y, radius, palette.WALL)
    elif disc.role == "health_pack":
        marks.health_cross(canvas, x, y, radius * 1.5)
    elif disc.role == "start":
        marks.dashed_ring(canvas, x, y, radius, line, palette.SECONDARY, dashes=14)
        canvas.write("S", x, y, radius * 0.95, weight="bold", colour=palette.SECONDARY,
                     align="centre")  # fmt: skip
