"""Where the parts of a fleet run go: tiles, line of guidance, and what may lie over them."""

from __future__ import annotations

import dataclasses
import functools

import pygame

from study.messages import noted
from study.screens import FleetScreen, Tile
from study.shell.drawing import chrome, legend
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.grid import TilePlace, place_enlarged, place_tiles
from study.shell.drawing.maps import MapView

MESSAGE_HEIGHT = 36
"""Design pixels for a line of guidance."""
NOBODY = noted("You are not driving a robot at the moment.")
NOBODY_SIZE = 22
RING = 2.7
"""Radius of the ring round a driven robot, in radii of its body as it is drawn elsewhere."""
STRIDE = 8
"""Pixels between the places tried for what lies over a fleet."""


@dataclasses.dataclass(frozen=True, slots=True)
class Layout:
    """Where a fleet screen's parts go, pixels.

    Attributes:
        tiles: one place a tile of the screen, in their order.
        large: where the operated robot is enlarged, whichever it is; None in other views.
        message: middle of the line of guidance.
    """

    tiles: tuple[TilePlace, ...]
    large: TilePlace | None
    message: int


def layout(canvas: Canvas, screen: FleetScreen) -> Layout:
    """Return where a screen's parts go."""
    enlarged = screen.view == "enlarged" and screen.robots > 1
    single = screen.view == "operated_only" or screen.robots == 1
    top = chrome.header_height(canvas)
    banded = (single or enlarged) and bool(screen.message)
    band = canvas.u(MESSAGE_HEIGHT) if banded else 0
    bottom = canvas.size[1] - legend.height(canvas)
    area = pygame.Rect(0, top + band, canvas.size[0], bottom - top - band)
    large = None
    if single:
        places = place_tiles(area, screen.scene, 1, canvas.scale)[: len(screen.tiles)]
    elif enlarged:
        large, places = place_enlarged(area, screen.scene, screen.robots, canvas.scale)
        places = [places[tile.robot] for tile in screen.tiles]
    else:
        places = _place_all(area, screen, canvas.scale)
    under = top + band // 2 + canvas.u(2)
    free = under if banded else _free_band(canvas, screen, places, top)
    return Layout(tuple(places), large, free)


def _place_all(area: pygame.Rect, screen: FleetScreen, scale: float) -> list[TilePlace]:
    """Return the places of a screen's tiles where none is enlarged, in their order."""
    if len(screen.tiles) < screen.robots:
        # A few of the fleet are offered: as large as there is room.
        places = place_tiles(area, screen.scene, max(1, len(screen.tiles)), scale)
        return places[: len(screen.tiles)]
    places = place_tiles(area, screen.scene, screen.robots, scale)
    return [places[tile.robot] for tile in screen.tiles]


def _has_free_band(canvas: Canvas, places: list[TilePlace], top: int) -> bool:
    """Whether a message has room between the header and the tiles."""
    highest = min((place.body.top for place in places), default=canvas.size[1])
    return not places or (places[0].bar > 0 and highest - top >= canvas.u(30))


def _free_band(canvas: Canvas, screen: FleetScreen, places: list[TilePlace], top: int) -> int:
    """Return where a message stands: under the header, or over the legend if that is taken."""
    highest = min((place.body.top for place in places), default=canvas.size[1])
    framed = any(
        tile.robot in (screen.operated, screen.suggested) and place.body.top == highest
        for tile, place in zip(screen.tiles, places, strict=True)
    )
    if places and not framed and _has_free_band(canvas, places, top):
        return (top + min(highest, top + canvas.u(80))) // 2 + canvas.u(2)
    return canvas.size[1] - legend.height(canvas) // 2


def tile_places(canvas: Canvas, screen: FleetScreen) -> list[TilePlace]:
    """Return the places of the screen's tiles, in their order; the enlarged one is not among."""
    return list(layout(canvas, screen).tiles)


def targets(canvas: Canvas, screen: FleetScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked: the tiles."""
    return [
        (f"robot:{tile.robot}", place.body)
        for tile, place in zip(screen.tiles, tile_places(canvas, screen), strict=True)
    ]


def nobody_room(canvas: Canvas, body: pygame.Rect) -> pygame.Rect:
    """Return where it is said, in place of an enlarged robot, that none is driven."""
    room = body.inflate(-canvas.u(60), -canvas.u(40))
    size = canvas.u(NOBODY_SIZE)
    height = canvas.paragraph_height(canvas.say(NOBODY), room.width, size, "semibold")
    room.top = max(room.top, body.centery - height // 2)
    room.height = body.bottom - canvas.u(10) - room.top
    return room


def clear_place(canvas: Canvas, screen: FleetScreen, side: int) -> tuple[int, int]:
    """Return where a square may lie over a fleet without hiding the participant's own robot.

    Nor does it hide that robot's number, a suggested robot, or that no robot is driven.

    Args:
        canvas: the screen is drawn on it.
        screen: the fleet.
        side: of the square, pixels.

    Returns:
        The square's middle, as near as can be to that of the window or the enlarged map.
    """
    places = layout(canvas, screen)
    wanted = (canvas.size[0] // 2, canvas.size[1] // 2)
    if places.large is not None:
        body = places.large.body
        wanted = (body.centerx, body.top + body.height // 4)
    kept = _kept_in_sight(canvas, screen, places)
    top, bottom = chrome.header_height(canvas), canvas.size[1] - legend.height(canvas)
    if screen.message and places.message < bottom:
        top = places.message + canvas.u(16)
    area = (0, top, canvas.size[0], bottom - top)
    return _nearest_free(wanted, side, area, tuple(tuple(place) for place in kept))


@functools.lru_cache(maxsize=8)
def _nearest_free(
    wanted: tuple[int, int],
    side: int,
    area: tuple[int, int, int, int],
    kept: tuple[tuple[int, ...], ...],
) -> tuple[int, int]:
    """Return the middle of a square in an area that touches none of some rectangles.

    It is the one nearest to what is wanted; that itself where there is none.
    """
    inner = pygame.Rect(area).inflate(-side, -side)
    tried = [wanted] + [
        (x, y)
        for x in range(inner.left, inner.right + 1, STRIDE)
        for y in range(inner.top, inner.bottom + 1, STRIDE)
    ]
    tried.sort(key=lambda at: (at[0] - wanted[0]) ** 2 + (at[1] - wanted[1]) ** 2)
    square = pygame.Rect(0, 0, side, side)
    for middle in tried:
        square.center = middle
        if square.collidelist(list(kept)) < 0:
            return middle
    return wanted


def _kept_in_sight(canvas: Canvas, screen: FleetScreen, places: Layout) -> list[pygame.Rect]:
    """Return what nothing may lie on, pixels."""
    kept = []
    if places.large is not None and screen.operated < 0:
        room = nobody_room(canvas, places.large.body)
        size = canvas.u(NOBODY_SIZE)
        height = canvas.paragraph_height(canvas.say(NOBODY), room.width, size, "semibold")
        kept.append(pygame.Rect(room.topleft, (room.width, min(height, room.height))))
    for tile, place in zip(screen.tiles, places.tiles, strict=True):
        if tile.robot not in (screen.operated, screen.suggested):
            continue
        shown = [place] if places.large is None else [place, places.large]
        for one in shown if tile.robot == screen.operated else [place]:
            kept += _own_places(screen, tile, one) if one.single else [one.body]
    return kept


def _own_places(screen: FleetScreen, tile: Tile, place: TilePlace) -> list[pygame.Rect]:
    """Return where a large tile shows its robot and what is written of it, pixels."""
    if screen.scene.camera:
        return [place.plate]
    view = MapView(screen.scene, place.map)
    robot = pygame.Rect(0, 0, *[round(2 * RING * view.robot_radius)] * 2)
    x, y = view.robot_point(tile.x, tile.y, driven=True)
    robot.center = (round(x), round(y))
    return [place.plate, robot]
