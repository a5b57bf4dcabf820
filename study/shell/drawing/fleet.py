"""The fleet run: header with progress and time, the tiles, the legend."""

from __future__ import annotations

import math

import pygame

from study.events.scene import Role
from study.screens import FleetScreen
from study.shell.drawing import chrome, legend, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.grid import TilePlace, place_tiles
from study.shell.drawing.motion import Motion
from study.shell.drawing.plate import PlateLook
from study.shell.drawing.tile import LABEL_SECONDS, TileView, draw_tile

MOST_BOXES = 16
"""Trials beyond which progress is words only."""
MESSAGE_HEIGHT = 36
CLOCK_ROOM = 168
"""Design pixels that the time left needs at least."""
CLOCK_BAR = 120
NOBODY = "You are not driving a robot at the moment."


def tile_places(canvas: Canvas, screen: FleetScreen) -> list[TilePlace]:
    """Return the places of the screen's tiles, in their order."""
    single = screen.view == "operated_only" or screen.robots == 1
    top = chrome.header_height(canvas)
    if single and screen.message:
        top += canvas.u(MESSAGE_HEIGHT)
    bottom = canvas.size[1] - legend.height(canvas)
    area = pygame.Rect(0, top, canvas.size[0], bottom - top)
    if single:
        return place_tiles(area, screen.scene, 1, canvas.scale)[: len(screen.tiles)]
    places = place_tiles(area, screen.scene, screen.robots, canvas.scale)
    return [places[tile.robot] for tile in screen.tiles]


def targets(canvas: Canvas, screen: FleetScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked: the tiles."""
    return [
        (f"robot:{tile.robot}", place.body)
        for tile, place in zip(screen.tiles, tile_places(canvas, screen), strict=True)
    ]


def draw(canvas: Canvas, screen: FleetScreen, motion: Motion, now_ns: int) -> None:
    """Draw the screen as it is at a session time.

    Args:
        canvas: to draw on.
        screen: what is shown.
        motion: has observed the screen.
        now_ns: session time.
    """
    canvas.surface.fill(palette.PAGE)
    _draw_strips(canvas, screen)
    accept = _accept_key(screen)
    since = (now_ns - screen.switched_ns) / 1e9 if screen.switched_ns >= 0 else -1.0
    for tile, place in zip(screen.tiles, tile_places(canvas, screen), strict=True):
        driven = tile.robot == screen.operated
        dwell_left = motion.dwell_left(screen, now_ns) if driven else -1.0
        look = PlateLook(
            driven=driven,
            suggested=tile.robot == screen.suggested and not driven,
            accept_key=accept,
            has_dwell=dwell_left >= 0,
            note=_note(screen) if place.single else "",
            key=_own_key(screen, tile.robot),
        )
        shown = TileView(
            place=place,
            tile=tile,
            look=look,
            pose=motion.pose(screen, tile, now_ns),
            since_switch=since if driven and since <= LABEL_SECONDS else -1.0,
            dwell_left=dwell_left,
        )
        draw_tile(canvas, screen.scene, shown)
    if not screen.tiles:
        canvas.write(
            NOBODY, canvas.size[0] / 2, canvas.size[1] / 2, canvas.u(26),
            weight="semibold", colour=palette.SECONDARY, align="centre",
        )  # fmt: skip
    if screen.message:
        _draw_message(canvas, screen)


def _draw_strips(canvas: Canvas, screen: FleetScreen) -> None:
    """Draw header and legend; they change at most a few times a second."""
    width, height = canvas.size
    total = max(screen.seconds_total, 1e-9)
    key = (
        screen.heading,
        screen.trial,
        screen.trials,
        screen.keys,
        clock_text(screen.seconds_left),
        round(screen.seconds_left / total * canvas.u(CLOCK_BAR)),
        screen.seconds_total > 0,
    )
    top = pygame.Rect(0, 0, width, chrome.header_height(canvas))
    canvas.remember("header", key, top, lambda: draw_header(canvas, screen))
    items = _legend_items(screen)
    low = legend.height(canvas)
    bottom = pygame.Rect(0, height - low, width, low)
    canvas.remember("legend", items, bottom, lambda: legend.draw(canvas, items))


def _own_key(screen: FleetScreen, robot: int) -> str:
    """Return the key that chooses a robot if it is not the robot's number."""
    key = screen.robot_keys[robot] if robot < len(screen.robot_keys) else ""
    return "" if key == str(robot + 1) else key


def _accept_key(screen: FleetScreen) -> str:
    for label, word in screen.keys:
        if word == "accept":
            return label
    return "Space"


def _note(screen: FleetScreen) -> str:
    others = screen.robots - 1
    if screen.view == "operated_only" and others > 0:
        if others == 1:
            return "The other robot drives itself."
        return f"The other {others} robots drive themselves."
    return ""


def _legend_items(screen: FleetScreen) -> list[legend.Item]:
    scene = screen.scene
    roles = {mark.role for mark in scene.rectangles} | {disc.role for disc in scene.discs}
    one_tile = len(screen.tiles) <= 1
    items: list[legend.Item] = []
    if screen.allocation != "none":
        items.append("driven")
    if not one_tile or screen.operated < 0:
        items.append("autonomous")
    if screen.allocation == "suggested":
        items.append("suggested")
    ordered: tuple[Role, ...] = ("hazard", "health_pack", "start", "goal")
    items += [role for role in ordered if role in roles]
    if not one_tile:
        items.append("stuck")
    return items


def _draw_message(canvas: Canvas, screen: FleetScreen) -> None:
    """Draw one line of guidance: under the header, or over the legend if that is taken."""
    size, height = canvas.u(20), canvas.u(32)
    width = canvas.text_width(screen.message, size, "semibold") + canvas.u(40)
    box = pygame.Rect(0, 0, min(width, canvas.size[0] - canvas.u(32)), height)
    box.centerx = canvas.size[0] // 2
    places = tile_places(canvas, screen)
    single = len(places) <= 1
    bar = places[0].bar if places else 0
    top = chrome.header_height(canvas)
    highest = min((place.body.top for place in places), default=canvas.size[1])
    framed = any(
        tile.robot in (screen.operated, screen.suggested) and place.body.top == highest
        for tile, place in zip(screen.tiles, places, strict=True)
    )
    if single or (bar and not framed):
        under = highest - (bar if single and places else 0)
        box.centery = (top + min(under, top + canvas.u(80))) // 2 + canvas.u(2)
    else:
        box.centery = canvas.size[1] - legend.height(canvas) // 2
    canvas.box(box, canvas.u(8), palette.INK)
    canvas.write(
        screen.message, box.centerx, box.centery, size, weight="semibold",
        colour=palette.CARD, align="centre", width=box.width - canvas.u(24),
    )  # fmt: skip


def clock_text(seconds: float) -> str:
    """Return a time left as minutes and seconds; a started second still counts."""
    whole = max(0, math.ceil(seconds - 1e-6))
    return f"{whole // 60}:{whole % 60:02d}"


def draw_header(canvas: Canvas, screen: FleetScreen) -> None:
    """Draw part, trial, time left and keys."""
    y = chrome.draw_header_ground(canvas)
    u, size = canvas.u, canvas.u(19)
    x = canvas.write(screen.heading, u(24), y, size, weight="semibold").right
    keys = _keys_width(canvas, screen, u(29), u(18), u(18))
    room = canvas.size[0] - u(24) - keys - (u(CLOCK_ROOM) if screen.seconds_total > 0 else u(20))
    if screen.trials > 0:
        canvas.surface.fill(palette.LINE, (x + u(19), y - u(14), 1, u(28)))
        words = f"{screen.unit} {screen.trial} of {screen.trials}"
        x = canvas.write(words, x + u(38), y, size, weight="semibold").right
        if screen.trials <= MOST_BOXES:
            roomy = x + u(15) + screen.trials * u(17) <= room
            x = _progress(canvas, screen, x + u(15), y, u(12) if roomy else u(8))
    keys_left = _draw_keys(canvas, screen, y, x)
    if screen.seconds_total > 0:
        _draw_clock(canvas, screen, x, keys_left, y)


def _progress(canvas: Canvas, screen: FleetScreen, x: int, y: int, width: int) -> int:
    """Draw a box a trial: done, running, to come; return where they end."""
    u = canvas.u
    for trial in range(1, screen.trials + 1):
        box = pygame.Rect(x, y - u(9), width, u(18))
        if trial < screen.trial:
            canvas.box(box, u(2), palette.AUTONOMOUS)
        elif trial == screen.trial:
            canvas.box(box, u(2), palette.CARD, palette.BLUE, u(3))
        else:
            canvas.box(box, u(2), palette.CARD, palette.EDGE, u(1.2))
        x += width + u(5 if width > u(10) else 4)
    return x


def _keys_width(canvas: Canvas, screen: FleetScreen, height: int, size: int, gap: int) -> int:
    widths = [chrome.keys_width(canvas, *pair, height, size) for pair in screen.keys]
    return sum(widths) + gap * max(0, len(widths) - 1)


def _draw_keys(canvas: Canvas, screen: FleetScreen, y: int, left: int) -> int:
    """Draw the keys in use from the right; return their left edge."""
    u = canvas.u
    right = canvas.size[0] - u(24)
    clock = u(CLOCK_ROOM) if screen.seconds_total > 0 else u(20)
    height, size, gap = u(29), u(18), u(18)
    while _keys_width(canvas, screen, height, size, gap) > right - left - clock and size > u(13):
        height, size, gap = height - 1, size - 1, max(u(8), gap - 2)
    x = start = right - _keys_width(canvas, screen, height, size, gap)
    for label, word in screen.keys:
        x += chrome.draw_keys(canvas, label, word, x, y, height, size) + gap
    return start


def _draw_clock(canvas: Canvas, screen: FleetScreen, left: int, right: int, y: int) -> None:
    """Draw the time left, in the middle of the window if there is room."""
    u = canvas.u
    text = clock_text(screen.seconds_left)
    room = right - left - u(40)
    number = canvas.text_width(text, u(26), "bold", tabular=True)
    word = canvas.text_width("left", u(18))
    bar = min(u(CLOCK_BAR), room - number - word - u(22))
    bar = bar if bar >= u(40) else 0
    total = number + u(10) + word + (u(14) + bar if bar else 0)
    middle = canvas.size[0] / 2
    start = max(left + u(20), min(middle - total / 2, right - u(20) - total))
    canvas.write(text, start, y, u(26), weight="bold", tabular=True)
    x = start + number + u(10)
    canvas.write("left", x, y + u(2), u(18), colour=palette.SECONDARY)
    if bar:
        box = pygame.Rect(round(x + word + u(14)), y - u(6), bar, u(12))
        canvas.box(box, u(2), palette.CARD, palette.EDGE, max(1, u(1.2)))
        inside = box.inflate(-2 * u(1.6), -2 * u(1.6))
        share = min(1.0, max(0.0, screen.seconds_left / screen.seconds_total))
        inside.width = round(inside.width * share)
        canvas.surface.fill(palette.AUTONOMOUS, inside)
