"""The label that names a robot where control has just come to it, within its map."""

from __future__ import annotations

import pygame

from study.shell.drawing import maps, palette
from study.shell.drawing.canvas import LEADING, Canvas
from study.shell.drawing.lettering import text_width, wrap

SIZE = 24
"""Of the text, design pixels; padding and edge are in proportion to it."""
SMALLEST = 0.5
"""Share of its size to which the text shrinks in a small map."""
LONE_LINE = 0.7
"""Share of its size under which two lines are larger, and better, than one."""
PAD_X, PAD_Y = 20 / 24, 11 / 24
"""Room around the text, in sizes of the text."""
REACH, BODY = 4.4, 2.4
"""Distance of the label from a robot's middle where there is room, and at least, in radii."""
MARGIN_X, MARGIN_Y = 24, 20
"""Distance from the map's edges where there is room, design pixels."""


def draw_label(
    canvas: Canvas,
    view: maps.MapView,
    robot: tuple[float, float],
    plate: pygame.Rect,
    text: str,
) -> None:
    """Name the robot beside it, on the side with more room, clear of the plate.

    Args:
        canvas: to draw on.
        view: the map, over whose edges nothing is drawn.
        robot: its middle, pixels.
        plate: what is to stay in sight, pixels.
        text: what is said.
    """
    lines, size = _fitted(canvas, text, view.place)
    box = _size_of(lines, size)
    box.topleft = _place(canvas, view, robot, plate, box)
    canvas.box(box, size * 0.3, palette.CARD, palette.BLUE, max(1.5, size / 8))
    leading = size * LEADING
    first = box.centery - leading * (len(lines) - 1) / 2
    for number, line in enumerate(lines):
        canvas.write(line, box.centerx, first + number * leading, size, weight="semibold",
                     align="centre")  # fmt: skip


def _size_of(lines: list[str], size: int) -> pygame.Rect:
    widest = max(text_width(line, "semibold", size) for line in lines)
    height = size * LEADING * (len(lines) - 1) + size * (1.25 + 2 * PAD_Y)
    return pygame.Rect(0, 0, round(widest + 2 * PAD_X * size), round(height))


def _fitted(canvas: Canvas, text: str, room: pygame.Rect) -> tuple[list[str], int]:
    """Return the lines and the size at which the label is no wider than the map."""
    full = max(1, canvas.u(SIZE))
    room = room.inflate(-canvas.u(8), -canvas.u(8))
    smallest = max(1, round(full * SMALLEST))
    for size in range(full, smallest - 1, -1):
        inside = round(room.width - 2 * PAD_X * size)
        lines = [text] if size >= full * LONE_LINE else wrap(text, "semibold", size, inside)
        box = _size_of(lines, size)
        if box.width <= room.width and box.height <= room.height:
            return lines, size
    return wrap(text, "semibold", smallest, inside), smallest


def _place(
    canvas: Canvas,
    view: maps.MapView,
    robot: tuple[float, float],
    plate: pygame.Rect,
    box: pygame.Rect,
) -> tuple[int, int]:
    """Return where the label's top left corner goes."""
    place = view.place
    wide = place.inflate(-canvas.u(2 * MARGIN_X), -canvas.u(2 * MARGIN_Y))
    narrow = place.inflate(-canvas.u(8), -canvas.u(8))
    body = pygame.Rect(0, 0, *[round(2 * BODY * view.robot_radius)] * 2)
    body.center = (round(robot[0]), round(robot[1]))
    found = []
    for reach, room in ((REACH, wide), (BODY, narrow)):
        away = reach * view.robot_radius
        below, above = round(robot[1] + away), round(robot[1] - away - box.height)
        if below + box.height > room.bottom and above >= room.top:
            below, above = above, below
        if view.scene.camera:
            # Nobody knows where in a picture the robot is.
            below = above = place.bottom - box.height
        beside = plate.right + canvas.u(24)
        for top in (below, above):
            at = box.move(round(robot[0]) - box.width // 2, top)
            at.clamp_ip(room)
            if at.colliderect(plate):
                at.left = max(at.left, beside)
            found.append(at)
    # In a small map none may be clear of all: the robot and its surroundings come first.
    found += [box.move(narrow.left, y) for y in (plate.bottom + 1, narrow.bottom - box.height)]
    for hidden in ((plate, body), (body,)):
        for at in found:
            if narrow.contains(at) and at.collidelist(list(hidden)) < 0:
                return at.topleft
    return found[-1].clamp(narrow).topleft
