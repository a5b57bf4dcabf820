"""Drawing of figures as SVG: plain marks whose colours are classes of the report's sheet.

Marks carry classes instead of colours and styles, so that a figure follows the page into dark
mode and print, and a strict content-security policy holds. The text of a drawing depends on
its data alone, to the byte.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from markupsafe import Markup, escape

Point = tuple[float, float]
TONES = 8
"""Colours of conditions in the report's sheet."""


class Drawing:
    """An SVG image under construction; x to the right, y downwards, in CSS pixels.

    Args:
        name: unique in the page; prefixes the ids.
        width: width of the view box.
        height: height of the view box.
        title: what the image shows, for those who cannot see it.
    """

    def __init__(self, name: str, width: float, height: float, title: str) -> None:
        self.name = name
        self.width = width
        self.height = height
        self.title = title
        self._parts: list[str] = []

    def line(self, start: Point, end: Point, classes: str) -> None:
        """Draw a straight line."""
        (x1, y1), (x2, y2) = start, end
        place = f'x1="{_n(x1)}" y1="{_n(y1)}" x2="{_n(x2)}" y2="{_n(y2)}"'
        self._parts.append(f'<line class="{classes}" {place}/>')

    def polyline(self, points: Sequence[Point], classes: str) -> None:
        """Draw an open line through points."""
        path = " ".join(f"{_n(x)},{_n(y)}" for x, y in points)
        self._parts.append(f'<polyline class="{classes} none" points="{path}"/>')

    def polygon(self, points: Sequence[Point], classes: str) -> None:
        """Draw a filled area."""
        path = " ".join(f"{_n(x)},{_n(y)}" for x, y in points)
        self._parts.append(f'<polygon class="{classes}" points="{path}"/>')

    def circle(self, centre: Point, radius: float, classes: str) -> None:
        """Draw a disc or, with the class "none", a ring."""
        place = f'cx="{_n(centre[0])}" cy="{_n(centre[1])}" r="{_n(radius)}"'
        self._parts.append(f'<circle class="{classes}" {place}/>')

    def rect(self, corner: Point, width: float, height: float, classes: str) -> None:
        """Draw a rectangle from its upper left corner."""
        place = f'x="{_n(corner[0])}" y="{_n(corner[1])}" width="{_n(width)}" height="{_n(height)}"'
        self._parts.append(f'<rect class="{classes}" {place}/>')

    def text(
        self, place: Point, text: str, classes: str = "", anchor: str = "start", size: float = 12
    ) -> None:
        """Write a line of text; y is its baseline.

        Args:
            place: where the anchor is.
            text: the text, escaped here.
            classes: colour and weight.
            anchor: "start", "middle" or "end".
            size: size of the type, pixels.
        """
        where = f'x="{_n(place[0])}" y="{_n(place[1])}"'
        shape = f'text-anchor="{anchor}" font-size="{_n(size)}"'
        self._parts.append(f'<text class="{classes}" {where} {shape}>{escape(text)}</text>')

    def image(self, corner: Point, width: float, height: float, uri: str, classes: str) -> None:
        """Place a picture given as a data URI, stretched to the size."""
        place = f'x="{_n(corner[0])}" y="{_n(corner[1])}" width="{_n(width)}" height="{_n(height)}"'
        self._parts.append(
            f'<image class="{classes}" {place} preserveAspectRatio="none" href="{escape(uri)}"/>'
        )

    def clip(self, name: str, rectangles: Sequence[tuple[float, float, float, float]]) -> str:
        """Define a clip made of rectangles (x, y, width, height) and return its id."""
        ident = f"figure-{self.name}-{name}"
        inner = "".join(
            f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(w)}" height="{_n(h)}"/>'
            for x, y, w, h in rectangles
        )
        self._parts.append(f'<clipPath id="{escape(ident)}">{inner}</clipPath>')
        return ident

    def open_group(self, clip: str = "", move: Point = (0.0, 0.0)) -> None:
        """Begin a group, clipped or moved."""
        clipped = f' clip-path="url(#{escape(clip)})"' if clip else ""
        moved = f' transform="translate({_n(move[0])} {_n(move[1])})"' if move != (0.0, 0.0) else ""
        self._parts.append(f"<g{clipped}{moved}>")

    def close_group(self) -> None:
        """End the group begun last."""
        self._parts.append("</g>")

    def markup(self) -> Markup:
        """Return the image, ready for the page."""
        box = f"0 0 {_n(self.width)} {_n(self.height)}"
        label = escape(f"figure-{self.name}-title")
        head = (
            f'<svg class="figure" viewBox="{box}" width="{_n(self.width)}" '
            f'height="{_n(self.height)}" role="img" aria-labelledby="{label}">'
            f'<title id="{label}">{escape(self.title)}</title>'
        )
        return Markup(head + "".join(self._parts) + "</svg>")  # noqa: S704 - every part is escaped


def _n(value: float) -> str:
    """Write a coordinate with at most two decimals."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


class Scale:
    """A linear axis: values to pixels, with round ticks.

    Args:
        values: what must fit in; zero is added on request.
        start: pixel of the lower end.
        end: pixel of the upper end.
        ticks: about how many ticks.
        zero: whether zero must be in view.
    """

    def __init__(
        self,
        values: Sequence[float],
        start: float,
        end: float,
        *,
        ticks: int = 6,
        zero: bool = False,
    ) -> None:
        finite = [value for value in values if math.isfinite(value)] or [0.0]
        low, high = min(finite), max(finite)
        if zero:
            low, high = min(low, 0.0), max(high, 0.0)
        if high - low < 1e-9:
            low, high = low - 1.0, high + 1.0
        step = round_step((high - low) / max(ticks - 1, 1))
        first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
        self.ticks = [place * step for place in range(first, last + 1)]
        self.step = step
        self._low, self._high = self.ticks[0], self.ticks[-1]
        self._start, self._end = start, end

    def __call__(self, value: float) -> float:
        """Return a value's pixel."""
        share = (value - self._low) / (self._high - self._low)
        return self._start + share * (self._end - self._start)

    def label(self, value: float, *, signed: bool = False) -> str:
        """Write a tick's value with the decimals that the step needs and a true minus."""
        decimals = max(0, -math.floor(math.log10(self.step) + 1e-9))
        text = f"{abs(value):.{decimals}f}"
        if float(text) == 0:
            return text
        sign = "−" if value < 0 else ("+" if signed else "")
        return sign + text


def tone(place: int) -> str:
    """Return the colour of a condition or level by its place; after eight they begin anew."""
    return f"c{place % TONES}"


def wrapped(text: str, width: float, size: float) -> list[str]:
    """Break a label into lines of about that width, px: at commas, else between words."""

    def fits(line: str) -> bool:
        return len(line) * size * 0.56 <= width

    lines: list[str] = []
    parts = text.split(", ")
    for place, part in enumerate(parts):
        piece = part if place == len(parts) - 1 else f"{part},"
        if lines and fits(f"{lines[-1]} {piece}"):
            lines[-1] += f" {piece}"
            continue
        lines.append("")
        for word in piece.split():
            longer = f"{lines[-1]} {word}".strip()
            if lines[-1] and not fits(longer):
                lines.append(word)
            else:
                lines[-1] = longer
    return lines


def round_step(rough: float) -> float:
    """Return the round number (1, 2 or 5 times a power of ten) at or just above a step."""
    power = 10.0 ** math.floor(math.log10(rough))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= rough * (1 - 1e-9))


def vertical_axis(
    drawing: Drawing, scale: Scale, left: float, right: float, *, signed: bool = False
) -> None:
    """Draw rules across a panel with their values on the left."""
    for tick in scale.ticks:
        y = scale(tick)
        drawing.line((left, y), (right, y), "s-rule")
        text = scale.label(tick, signed=signed)
        drawing.text((left - 10, y + 4), text, "f-quiet", "end", 11.5)


def panel_title(drawing: Drawing, x: float, letter: str, title: str, unit: str) -> None:
    """Write a panel's letter, if it has one, title and unit along its top."""
    if letter:
        drawing.text((x, 14), letter, "f-ink bold", size=13)
        x += 18
    drawing.text((x, 14), title, "f-ink bold", size=12)
    drawing.text((x + 6.7 * len(title) + 10, 14), unit, "f-quiet", size=11.5)
