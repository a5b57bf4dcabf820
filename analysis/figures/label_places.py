"""Where to write values beside marks, so that they cross as little as possible."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence


@dataclasses.dataclass(frozen=True, slots=True)
class Box:
    """A rectangle of the drawing, by its edges in pixels; y downwards."""

    left: float
    top: float
    right: float
    bottom: float

    def overlap(self, other: Box) -> float:
        """Return the area that two boxes share, square pixels."""
        width = min(self.right, other.right) - max(self.left, other.left)
        height = min(self.bottom, other.bottom) - max(self.top, other.top)
        return max(width, 0.0) * max(height, 0.0)

    @property
    def area(self) -> float:
        """Width times height, square pixels."""
        return (self.right - self.left) * (self.bottom - self.top)


@dataclasses.dataclass(frozen=True, slots=True)
class Label:
    """A text's place: its anchor point on the baseline, and which end the anchor is."""

    x: float
    y: float
    anchor: str
    box: Box


def place_labels(
    marks: Sequence[tuple[float, float]],
    widths: Sequence[float],
    obstacles: Sequence[Box],
    frame: Box,
    radius: float = 8.0,
    size: float = 12.0,
) -> list[Label]:
    """Place a label beside each mark: at its right if it is free there, or else elsewhere.

    Args:
        marks: centres of the marks.
        widths: of the texts, pixels.
        obstacles: what a text must not cross.
        frame: where texts must stay.
        radius: of a mark.
        size: of the type, pixels.

    Returns:
        One place for each mark, in their order. Of places that cross equally much the first in a
        fixed order is taken, so that the same data give the same drawing.
    """
    rings = [Box(x - radius, y - radius, x + radius, y + radius) for x, y in marks]
    placed: list[Label] = []
    for place, width in enumerate(widths):
        taken = [*obstacles, *rings[:place], *rings[place + 1 :], *(label.box for label in placed)]
        found = _candidates(marks[place], width, radius, size)
        placed.append(min(found, key=lambda label: _crossed(label.box, taken, frame)))
    return placed


def _crossed(box: Box, taken: Sequence[Box], frame: Box) -> float:
    outside = box.area - box.overlap(frame)
    return round(4 * outside + sum(box.overlap(other) for other in taken), 6)


def _candidates(mark: tuple[float, float], width: float, radius: float, size: float) -> list[Label]:
    x, y = mark
    gap = radius + 4
    middle, above, below = y + size / 3, y - gap, y + gap + 0.75 * size
    places = [
        (x + gap, middle, "start"),
        (x - gap, middle, "end"),
        (x, above, "middle"),
        (x, below, "middle"),
        *((x + gap - 3, baseline, "start") for baseline in (above + 4, below - 4)),
        *((x - gap + 3, baseline, "end") for baseline in (above + 4, below - 4)),
        (x, above - size, "middle"),
        (x, below + size, "middle"),
    ]
    return [
        Label(left, baseline, anchor, _box(left, baseline, anchor, width, size))
        for left, baseline, anchor in places
    ]


def _box(x: float, baseline: float, anchor: str, width: float, size: float) -> Box:
    left = {"start": x, "middle": x - width / 2, "end": x - width}[anchor]
    return Box(left - 1, baseline - 0.8 * size, left + width + 1, baseline + 0.15 * size)
