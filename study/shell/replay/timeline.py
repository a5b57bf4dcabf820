"""A line of time with what is marked on it: trials, surveys, takeovers, pauses and faults."""

from __future__ import annotations

import dataclasses

import pygame

from study.shell.drawing import marks as shapes
from study.shell.drawing import palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.palette import Colour
from study.shell.replay.marks import Marks, Span, TakeoverBy

TAKEOVERS: dict[TakeoverBy, tuple[str, Colour]] = {
    "operator": ("operator's takeover", palette.BLUE),
    "scorer": ("automatic", palette.INK),
    "suggestion": ("accepted", palette.ORANGE),
}
"""What a takeover's tick is called, and its colour; the operator's stand above the line."""
FAULT = palette.VERMILLION
PLAYED = palette.BLUE_TINT


@dataclasses.dataclass(frozen=True, slots=True)
class Line:
    """A stretch of session time laid out from left to right.

    Attributes:
        place: of the line, pixels of the strip.
        first_ns, last_ns: session times at its ends.
    """

    place: pygame.Rect
    first_ns: int
    last_ns: int

    def x_of(self, t_ns: int) -> float:
        """Return where a session time is, pixels from the strip's left."""
        share = (t_ns - self.first_ns) / max(1, self.last_ns - self.first_ns)
        return self.place.left + share * self.place.width

    def time_at(self, x: float) -> int:
        """Return the session time of a place, pixels from the strip's left."""
        share = (x - self.place.left) / self.place.width
        return self.first_ns + round(min(1.0, max(0.0, share)) * (self.last_ns - self.first_ns))

    def holds(self, t_ns: int) -> bool:
        """Return whether a session time is on the line."""
        return self.first_ns <= t_ns <= self.last_ns


def draw_line(
    canvas: Canvas, marks: Marks, line: Line, t_ns: int, name: str, *, numbered: bool = False
) -> None:
    """Draw a line of time, with the time it is; numbered: with the robots taken over."""
    left = canvas.u(16)
    canvas.write(name, left, line.place.centery, canvas.u(15), colour=palette.SECONDARY,
                 width=line.place.left - left - canvas.u(6))  # fmt: skip
    around = line.place.inflate(canvas.u(16), canvas.u(14))

    def paint() -> None:
        _draw_still(canvas, marks, line, numbered=numbered)

    canvas.remember(("line", line.place.top), line, around, paint)
    if not line.holds(t_ns):
        return
    x = round(line.x_of(t_ns))
    width = max(2, canvas.u(2))
    top, height = line.place.top - canvas.u(5), line.place.height + canvas.u(10)
    canvas.surface.fill(palette.CARD, (x - width // 2 - 1, top, width + 2, height))
    canvas.surface.fill(palette.BLUE_DARK, (x - width // 2, top, width, height))


def _draw_still(canvas: Canvas, marks: Marks, line: Line, *, numbered: bool) -> None:
    surface, place = canvas.surface, line.place
    surface.fill(palette.CARD, place.inflate(canvas.u(16), canvas.u(14)))
    band = _band(place)
    surface.fill(palette.PAGE, band)
    for span in marks.spans:
        if span.kind != "stage" and span.last_ns >= line.first_ns and span.first_ns <= line.last_ns:
            _draw_span(canvas, span, line, band)
    # Each side's next tick, from the right: a number is written where there is room for it.
    ahead = {True: line.place.right + canvas.u(40), False: line.place.right + canvas.u(40)}
    for takeover in reversed(marks.takeovers):
        if not line.holds(takeover.t_ns):
            continue
        x, below = round(line.x_of(takeover.t_ns)), takeover.by == "scorer"
        _draw_takeover(canvas, x, band, takeover.by)
        words, size = str(takeover.robot + 1), canvas.u(13)
        room = ahead[below] - x - canvas.u(8)
        if numbered and canvas.text_width(words, size) <= room:
            y = band.bottom + canvas.u(6) if below else band.top - canvas.u(6)
            canvas.write(words, x + canvas.u(4), y, size)
        ahead[below] = x
    for fault in marks.faults:
        if line.holds(fault.t_ns):
            shapes.triangle_down(canvas, line.x_of(fault.t_ns), place.top, canvas.u(11), FAULT)


def _band(place: pygame.Rect) -> pygame.Rect:
    """Return where spans are drawn: ticks stand over and under it."""
    return place.inflate(0, -2 * round(place.height * 0.3))


def _draw_span(canvas: Canvas, span: Span, line: Line, band: pygame.Rect) -> None:
    left = max(band.left, round(line.x_of(span.first_ns)))
    right = min(band.right, max(left + 2, round(line.x_of(span.last_ns))))
    place = pygame.Rect(left, band.top, max(1, right - left - 1), band.height)
    if span.kind == "trial":
        canvas.surface.fill(palette.EDGE if span.operated else palette.KEY_SHADE, place)
    elif span.kind == "survey":
        _outlined(canvas, place, palette.CARD)
    else:
        _outlined(canvas, place, palette.YELLOW)


def _outlined(canvas: Canvas, place: pygame.Rect, fill: Colour) -> None:
    canvas.surface.fill(palette.EDGE, place)
    canvas.surface.fill(fill, place.inflate(-2, -2))


def _draw_takeover(canvas: Canvas, x: int, band: pygame.Rect, by: TakeoverBy) -> None:
    height = canvas.u(10)
    top = band.bottom + 1 if by == "scorer" else band.top - height - 1
    canvas.surface.fill(TAKEOVERS[by][1], (x - 1, top, max(1, canvas.u(2)), height))


def draw_key(canvas: Canvas, left: int, y: int, size: int) -> int:
    """Say what is drawn on a line; return where that ends, pixels."""
    x, gap = left, canvas.u(14)
    height = canvas.u(11)
    samples: tuple[tuple[str, Colour, bool], ...] = (
        ("trial", palette.EDGE, False), ("survey", palette.CARD, True),
        ("pause", palette.YELLOW, True),
    )  # fmt: skip
    for word, colour, outlined in samples:
        box = pygame.Rect(x, y - height // 2, canvas.u(14), height)
        if outlined:
            _outlined(canvas, box, colour)
        else:
            canvas.surface.fill(colour, box)
        x = canvas.write(word, box.right + canvas.u(5), y, size).right + gap
    for word, colour in TAKEOVERS.values():
        canvas.surface.fill(colour, (x, y - canvas.u(5), max(2, canvas.u(3)), canvas.u(10)))
        x = canvas.write(word, x + canvas.u(7), y, size).right + gap
    shapes.triangle_down(canvas, x + canvas.u(5), y, canvas.u(11), FAULT)
    return canvas.write("fault", x + canvas.u(13), y, size).right
