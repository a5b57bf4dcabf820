"""Frames around tiles. They mean control only: solid blue is driven, dashed orange suggested."""

from __future__ import annotations

import pygame

from study.messages import noted
from study.shell.drawing import chrome, marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.grid import TilePlace

FRAME = 6
"""Design pixels."""
SOON = noted("switch soon")


def frame_rect(canvas: Canvas, place: TilePlace) -> pygame.Rect:
    """Return the rectangle that a tile takes with its frame and bar, pixels."""
    edge = canvas.u(FRAME)
    body = place.body
    top = body.top - max(place.bar, edge)
    return pygame.Rect(body.left - edge, top, body.width + 2 * edge, body.bottom + edge - top)


def driven_frame(
    canvas: Canvas, place: TilePlace, robot: int, *, announced: bool = False, arrows: bool = True
) -> None:
    """Draw the blue frame of a driven robot (index from 0), with its bar if it has one.

    Where a switch is announced, the bar says so in place of the arrows, if it has some.
    """
    frame = frame_rect(canvas, place)
    body = place.body
    canvas.box(frame, canvas.u(6), palette.BLUE)
    canvas.surface.fill(palette.CARD, body.inflate(2, 2))
    if not place.bar:
        return
    middle = (frame.top + body.top) / 2
    size = canvas.u(28 if place.single else 21)
    title = canvas.say("YOU")
    if place.single:
        title = canvas.say("YOU  ·  robot {number}", number=robot + 1)
    left = body.left + canvas.u(20 if place.single else 10)
    arrow = canvas.u(20 if place.single else 16)
    right = body.right - canvas.u(20 if place.single else 12)
    needed = arrow * (1 + 3 * 1.38)
    soon = canvas.say(SOON)
    room = right - left - canvas.u(8)
    written = canvas.write(title, left, middle, size, weight="bold", colour=palette.CARD,
                           width=room)  # fmt: skip
    if announced and canvas.fits(soon, size, room - written.width - canvas.u(16)):
        canvas.write(soon, right, middle, size, weight="semibold", colour=palette.CARD,
                     align="right", width=room - written.width - canvas.u(16))  # fmt: skip
        return
    if not arrows or room - written.width < needed:
        return
    for number, direction in enumerate(("right", "down", "up", "left")):
        x = right - arrow / 2 - number * arrow * 1.38
        marks.arrow(canvas, x, middle, arrow, direction, palette.CARD, max(1.6, arrow * 0.1))


def suggested_frame(canvas: Canvas, place: TilePlace, robot: int, key: str) -> None:
    """Draw the dashed frame of a suggested robot (index from 0): which key accepts it."""
    frame = frame_rect(canvas, place)
    body = place.body
    edge = canvas.u(FRAME)
    box = pygame.Rect(frame.left, body.top - edge, frame.width, frame.bottom - body.top + edge)
    canvas.surface.fill(palette.INK, box)
    inner = body.inflate(2, 2)
    canvas.surface.fill(palette.CARD, inner)
    _dashes(canvas, box, edge)
    canvas.surface.fill(palette.CARD, inner)
    if not place.bar:
        return
    bar = pygame.Rect(frame.left, frame.top, frame.width, body.top - frame.top)
    canvas.box(bar, canvas.u(5), palette.ORANGE, palette.INK, canvas.u(1.5))
    _how_to_accept(canvas, bar, robot, key)


def _how_to_accept(canvas: Canvas, bar: pygame.Rect, robot: int, key: str) -> None:
    """Write which key accepts a suggestion, the key drawn as a key; smaller in a narrow bar."""
    sentence = canvas.say("Press {key} to drive {number}", key="\0", number=robot + 1)
    before, _, after = (part.strip() for part in sentence.partition("\0"))
    name = chrome.key_text(canvas, chrome.key_tokens(key)[0])
    space, pad = canvas.u(8), canvas.u(14)
    for size in range(canvas.u(20), canvas.u(11), -1):
        cap = canvas.text_width(name, size * 0.85, "bold") + pad
        widths = [canvas.text_width(part, size, "semibold") for part in (before, after)]
        if cap + sum(widths) + 2 * space <= bar.width - 2 * canvas.u(8):
            break
    else:
        # No room for a sentence: the key says enough beside the dashed frame.
        size, before, after, widths = canvas.u(15), "", "", [0, 0]
        cap = canvas.text_width(name, size * 0.85, "bold") + pad
        space = 0
    height = size * 1.1
    x = bar.left + min(pad, (bar.width - cap - sum(widths) - 2 * space) / 2)
    canvas.write(before, x, bar.centery, size, weight="semibold")
    x += widths[0] + space
    place = pygame.Rect(round(x), round(bar.centery - height / 2), round(cap), round(height))
    canvas.box(place, canvas.u(5), palette.CARD, palette.INK, canvas.u(1.2))
    canvas.write(name, x + cap / 2, bar.centery, size * 0.85, weight="bold", align="centre")
    canvas.write(after, x + cap + space, bar.centery, size, weight="semibold")


def _dashes(canvas: Canvas, box: pygame.Rect, edge: int) -> None:
    """Fill the edge of a box with orange dashes on ink."""
    dash, pitch = canvas.u(14), canvas.u(24)
    rim = max(1, canvas.u(1))
    for x in range(box.left + rim, box.right, pitch):
        width = min(dash, box.right - rim - x)
        for y in (box.top + rim, box.bottom - edge + rim):
            canvas.surface.fill(palette.ORANGE, (x, y, width, edge - 2 * rim))
    for y in range(box.top + rim, box.bottom, pitch):
        height = min(dash, box.bottom - rim - y)
        for x in (box.left + rim, box.right - edge + rim):
            canvas.surface.fill(palette.ORANGE, (x, y, edge - 2 * rim, height))
