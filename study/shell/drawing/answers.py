"""Answers that are no short row of numbers: long scales, choices, numbers and free text."""

from __future__ import annotations

import pygame

from study.questionnaire import TENS_FROM
from study.screens import SurveyItem
from study.shell.drawing import marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.lettering import fitting_end

MOST_NUMBERED = 11
"""Answers of a scale that are drawn as numbered boxes; a longer one is a ruler."""

NUMBER_KEYS = (*"1234567890", "delete")
"""What is drawn beside a number, so that the mouse alone can enter it."""


def values(item: SurveyItem) -> range:
    """Return the answers that stand side by side, from the lowest; what is typed is one."""
    if is_typed(item):
        return range(1)
    return range(item.low, item.high + 1, item.step)


def is_typed(item: SurveyItem) -> bool:
    """Whether an item is answered by typing."""
    return item.kind in ("number", "text")


def is_plain(item: SurveyItem) -> bool:
    """Whether an item is a row of numbered boxes."""
    return item.kind == "scale" and len(values(item)) <= MOST_NUMBERED


def box_width(item: SurveyItem, pitch: float, usual: int) -> int:
    """Return the width of one answer, pixels, where answers are ``pitch`` apart."""
    if item.kind == "choice":
        return round(pitch * 0.94)
    if is_typed(item):
        return round(pitch)
    return min(usual, round(pitch * 0.74)) if is_plain(item) else max(3, round(pitch))


def number_boxes(canvas: Canvas, row: pygame.Rect) -> tuple[pygame.Rect, ...]:
    """Return the place of a number and of the keys to its right, pixels."""
    field = pygame.Rect(row.topleft, (round(row.width * 0.28), row.height))
    left, gap = field.right + canvas.u(16), canvas.u(8)
    pitch = (row.right + gap - left) / len(NUMBER_KEYS)
    keys = (
        pygame.Rect(round(left + place * pitch), row.top, round(pitch) - gap, row.height)
        for place in range(len(NUMBER_KEYS))
    )
    return (field, *keys)


def number_targets(item: SurveyItem) -> list[str]:
    """Return what the keys beside a number are, from the left."""
    return [
        f"delete:{item.item}" if key == "delete" else f"digit:{item.item}:{key}"
        for key in NUMBER_KEYS
    ]


def draw(
    canvas: Canvas, item: SurveyItem, boxes: tuple[pygame.Rect, ...], *, focused: bool
) -> None:
    """Draw the answers of an item that is not plain into its boxes."""
    if item.kind == "scale":
        _draw_ruler(canvas, item, boxes)
    elif item.kind == "choice":
        size = _option_size(canvas, item.options, boxes)
        for number, (option, box) in enumerate(zip(item.options, boxes, strict=True), start=1):
            _draw_option(canvas, option, box, number, size, chosen=item.value == number)
    else:
        _draw_typed(canvas, item, boxes[0], focused=focused)
        for key, box in zip(NUMBER_KEYS, boxes[1:], strict=False):
            _draw_number_key(canvas, key, box)


def status(canvas: Canvas, item: SurveyItem, *, focused: bool) -> str:
    """Return the line under the answers; empty where the usual one fits."""
    if item.kind == "choice" and item.value is not None:
        return canvas.say("You can still change it.")
    if item.kind == "choice" and focused:
        return canvas.say("Press a number from {low} to {high}.", low=1, high=len(item.options))
    if item.kind == "number" and item.value is None:
        return canvas.say("Type a number from {low} to {high}.", low=item.low, high=item.high)
    if item.kind == "number":
        return canvas.say("You can still change it.")
    if item.kind == "text":
        return canvas.say("Type your answer. Backspace deletes.")
    if item.kind == "scale" and not is_plain(item) and item.value is None and focused:
        if item.high >= TENS_FROM:
            return canvas.say("Type a number; one digit alone counts for tens.")
        return canvas.say("Type a number from {low} to {high}.", low=item.low, high=item.high)
    return ""


def _draw_ruler(canvas: Canvas, item: SurveyItem, boxes: tuple[pygame.Rect, ...]) -> None:
    u = canvas.u
    first, last = boxes[0], boxes[-1]
    middle = first.centery
    canvas.surface.fill(
        palette.EDGE, (first.centerx, middle - 1, last.centerx - first.centerx, max(2, u(2)))
    )
    for value, box in zip(values(item), boxes, strict=True):
        tall = u(26 if value in (item.low, (item.low + item.high) // 2, item.high) else 15)
        canvas.surface.fill(palette.EDGE, (box.centerx - 1, middle - tall // 2, max(2, u(2)), tall))
        if item.value == value:
            x = min(max(box.centerx, first.left + u(28)), last.right - u(28))
            place = pygame.Rect(0, 0, u(60), u(42))
            place.center = (x, middle)
            canvas.box(place, u(8), palette.BLUE, palette.BLUE_DARK, u(2))
            canvas.write(
                str(value), place.centerx, place.centery, u(24), weight="bold",
                colour=palette.CARD, align="centre",
            )  # fmt: skip


def _option_room(canvas: Canvas, box: pygame.Rect) -> pygame.Rect:
    """Return where the words of an option go, clear of its number and border."""
    u = canvas.u
    return pygame.Rect(box.left + u(38), box.top + u(5), box.width - u(48), box.height - 2 * u(5))


def _option_size(canvas: Canvas, options: tuple[str, ...], boxes: tuple[pygame.Rect, ...]) -> int:
    """Return one size at which all options of a question fit, pixels."""
    size = canvas.u(20)
    rooms = [_option_room(canvas, box) for box in boxes]
    while size > canvas.u(13) and any(
        canvas.paragraph_height(option, room.width, size) > room.height
        for option, room in zip(options, rooms, strict=True)
    ):
        size -= 1
    return size


def _draw_option(
    canvas: Canvas, option: str, box: pygame.Rect, number: int, size: int, *, chosen: bool
) -> None:
    u = canvas.u
    fill = palette.BLUE if chosen else palette.CARD
    colour = palette.CARD if chosen else palette.INK
    canvas.box(box, u(8), fill, palette.BLUE_DARK if chosen else palette.EDGE, u(2))
    canvas.write(str(number), box.left + u(16), box.centery, u(20), weight="bold", colour=colour)
    room = _option_room(canvas, box)
    height = canvas.paragraph_height(option, room.width, size)
    room.top += max(0, (room.height - height) // 2)
    room.height = max(room.height, height)
    canvas.paragraph(option, room, size, colour=colour)
    if chosen:
        marks.tick(canvas, box.right - u(14), box.top + u(14), u(16), palette.CARD, u(3))


def _draw_typed(canvas: Canvas, item: SurveyItem, box: pygame.Rect, *, focused: bool) -> None:
    u = canvas.u
    edge = palette.BLUE_DARK if focused else palette.EDGE
    canvas.box(box, u(8), palette.CARD, edge, u(2))
    size, room = u(21), box.width - u(40)
    # The end of what is typed stays in sight.
    shown = fitting_end(item.typed, "medium", max(1, size), room)
    drawn = canvas.write(shown, box.left + u(16), box.centery, size)
    if focused:
        x = drawn.right + u(3) if shown else box.left + u(16)
        canvas.surface.fill(palette.BLUE_DARK, (x, box.centery - u(14), max(2, u(2)), u(28)))


def _draw_number_key(canvas: Canvas, key: str, box: pygame.Rect) -> None:
    u = canvas.u
    canvas.box(box, u(8), palette.CARD, palette.EDGE, u(2))
    size = min(u(24), box.height * 0.5)
    if key == "delete":
        marks.arrow(
            canvas, box.centerx, box.centery, size, "left", palette.INK, max(1.6, size * 0.1)
        )
        return
    canvas.write(key, box.centerx, box.centery, size, weight="semibold", align="centre")
