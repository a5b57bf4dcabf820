"""Names beside a picture, each joined by a line to what it names."""

from __future__ import annotations

import dataclasses

import pygame

from study.shell.drawing import marks, palette
from study.shell.drawing.canvas import Canvas

NOTE_HEIGHT = 58


@dataclasses.dataclass(frozen=True, slots=True)
class Note:
    """One name.

    Attributes:
        name: in bold; a text of the catalogue.
        text: under it, likewise.
        anchor: the point named, pixels.
        level: whether the anchor may move up or down to stand beside its name.
    """

    name: str
    text: str
    anchor: tuple[float, float]
    level: bool = False


def spread(wanted: list[float], low: float, high: float, pitch: float) -> list[float]:
    """Move ascending places apart to at least ``pitch``, within ``low`` to ``high``.

    Where there is no room for that, they are spread evenly.
    """
    count = len(wanted)
    if count == 0:
        return []
    pitch = min(pitch, (high - low) / max(1, count - 1)) if count > 1 else pitch
    places: list[float] = []
    for number, place in enumerate(wanted):
        least = low if not places else places[-1] + pitch
        most = high - (count - 1 - number) * pitch
        places.append(min(max(place, least), max(most, least)))
    return places


def draw(canvas: Canvas, notes: list[Note], column: pygame.Rect, edge: int) -> None:
    """Draw names in a column at the right of a picture, with their lines.

    Args:
        canvas: to draw on.
        notes: what is named.
        column: where the names go.
        edge: right edge of the picture, pixels.
    """
    u = canvas.u
    ordered = sorted(notes, key=lambda note: note.anchor[1])
    half = u(NOTE_HEIGHT) / 2
    places = spread(
        [note.anchor[1] + u(12) for note in ordered],
        column.top + half, column.bottom - half, u(NOTE_HEIGHT),
    )  # fmt: skip
    stroke = max(1.2, u(1.4))
    lines = []
    for note, y in zip(ordered, places, strict=True):
        name_y = y - u(12)
        anchor = (note.anchor[0], name_y) if note.level else note.anchor
        bend = edge + u(10)
        lines.append([anchor, (bend, name_y), (column.left - u(8), name_y)])
        canvas.write(canvas.say(note.name), column.left, name_y, u(19), weight="semibold",
                     width=column.width)  # fmt: skip
        canvas.write(canvas.say(note.text), column.left, y + u(12), u(18), colour=palette.SECONDARY,
                     width=column.width)  # fmt: skip
    for line in lines:
        _draw_line(canvas, line, stroke + 2 * max(1.5, u(2)), palette.CARD)
        marks.disc(canvas, *line[0], u(5.5), palette.CARD)
    for line in lines:
        _draw_line(canvas, line, stroke, palette.INK)
        marks.disc(canvas, *line[0], u(4), palette.INK)


def _draw_line(
    canvas: Canvas, points: list[tuple[float, float]], width: float, colour: palette.Colour
) -> None:
    left = min(x for x, _ in points) - width
    top = min(y for _, y in points) - width
    size = (max(x for x, _ in points) + width - left, max(y for _, y in points) + width - top)

    def paint(surface: pygame.Surface, k: float) -> None:
        moved = [((x - left) * k, (y - top) * k) for x, y in points]
        marks.thick_line(surface, colour, moved, width * k)

    key = ("leader", tuple((round(x), round(y)) for x, y in points), width, colour)
    sprite = canvas.sprite(key, *size, paint)
    canvas.surface.blit(sprite, (round(left), round(top)), special_flags=pygame.BLEND_PREMULTIPLIED)
