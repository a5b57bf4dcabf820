"""Where to write values beside marks, so that they cross as little as possible."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

REACH = 8
"""Steps in which places farther away are tried, pixels."""


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
    """Place a label beside each mark: at its right if it is free there, or else near it.

    Args:
        marks: centres of the marks.
        widths: of the texts, pixels.
        obstacles: what a text must not cross.
        frame: where texts must stay.
        radius: of a mark.
        size: of the type, pixels.

    Returns:
        One place for each mark, in their order: the nearest of those that cross least. Of equals
        the first is taken, so that the same data give the same drawing.
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
    """Return places at both sides, above and below, nearest first."""
    x, y = mark
    middle = y + size / 3
    found: list[tuple[float, float, float, str]] = []
    for away in range(0, 5 * REACH, REACH):
        for rise in sorted(range(-4 * REACH, 5 * REACH, REACH), key=abs):
            # Above or below the ring a text may begin over it.
            gap = radius + 4 if abs(rise) < size + radius else 0.0
            far = away + abs(rise) + gap / 2
            found.append((far, x + gap + away, middle + rise, "start"))
            found.append((far + 0.5, x - gap - away, middle + rise, "end"))
    found.sort(key=lambda place: place[0])
    return [
        Label(left, baseline, anchor, _box(left, baseline, anchor, width, size))
        for _, left, baseline, anchor in found
    ]


def _box(x: float, baseline: float, anchor: str, width: float, size: float) -> Box:
    left = x if anchor == "start" else x - width
    return Box(left - 1, baseline - 0.8 * size, left + width + 1, baseline + 0.15 * size)
