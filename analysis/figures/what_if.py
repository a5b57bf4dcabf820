"""Figures of what-if: dots with intervals, the matrix, and where scorer and operator part."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from analysis.figures.svg import Drawing, Scale, panel_title, vertical_axis
from analysis.formatting import fraction
from analysis.statistics.result import Interval

WIDTH = 920.0
LABELS = 190.0
ROW, TOP = 26.0, 46.0
MARKS = ("c1", "c0", "c2", "c3", "c4", "c5")
LONGEST = 26
MOST_NUMBERS = 16
"""Participants up to which the matrix's cells hold their numbers."""

Dot = tuple[float, Interval | None]


def dot_panels(
    name: str,
    labels: Sequence[str],
    panels: Sequence[tuple[str, str, Sequence[Dot | None], float | None]],
    title: str,
    none: str,
) -> Drawing:
    """Draw a row for each label, and a panel for each measure: means with their intervals.

    Args:
        name: unique in the page.
        labels: of the rows.
        panels: (title, unit, a dot for each row, reference that is dashed or None).
        title: what the figure shows, for those who cannot see it.
        none: written where there is no dot.
    """
    drawing = Drawing(name, WIDTH, TOP + ROW * len(labels) + 30, title)
    for row, label in enumerate(labels):
        text = label if len(label) <= LONGEST else label[: LONGEST - 1] + "…"
        drawing.text((0, TOP + ROW * (row + 0.5) + 4), text, "f-ink", size=12)
    width = (WIDTH - LABELS) / len(panels)
    for place, (heading, unit, dots, reference) in enumerate(panels):
        left = LABELS + place * width
        panel_title(drawing, left, "abc"[place], heading, unit)
        _dots(drawing, dots, reference, (left, left + width - 40), none)
    return drawing


def _dots(
    drawing: Drawing,
    dots: Sequence[Dot | None],
    reference: float | None,
    ends: tuple[float, float],
    none: str,
) -> None:
    left, right = ends
    reach = [0.0] if reference is None else [0.0, reference]
    for dot in dots:
        if dot is not None:
            reach += [dot[0], *((dot[1].low, dot[1].high) if dot[1] else ())]
    scale = Scale(reach, left + 6, right - 6, ticks=5)
    bottom = TOP + ROW * len(dots)
    for tick in scale.ticks:
        drawing.line((scale(tick), TOP - 6), (scale(tick), bottom), "s-rule")
        drawing.text((scale(tick), bottom + 17), scale.label(tick), "f-quiet", "middle", 11.5)
    if reference is not None:
        drawing.line((scale(reference), TOP - 12), (scale(reference), bottom), "s-quiet dashed")
        drawing.text((scale(reference), TOP - 16), "chance", "f-quiet", "middle", 10.5)
    for row, dot in enumerate(dots):
        y = TOP + ROW * (row + 0.5)
        if dot is None:
            drawing.text((scale(0.0) + 4, y + 4), none, "f-quiet italic", size=11)
            continue
        if dot[1] is not None:
            drawing.line((scale(dot[1].low), y), (scale(dot[1].high), y), "s-c1 medium")
        drawing.circle((scale(dot[0]), y), 4.2, "f-c1 s-paper")


def matrix_cells(
    name: str,
    owners: Sequence[str],
    people: Sequence[str],
    values: npt.NDArray[np.float64],
    title: str,
) -> Drawing:
    """Draw a matrix: darker means better; a participant's own scorer is framed.

    Args:
        name: unique in the page.
        owners: whose scorers, a row each.
        people: whose choices, a column each.
        values: float64 [owners, people]; nan is left empty.
        title: what the figure shows, for those who cannot see it.
    """
    left, top = 130.0, 48.0
    cell = min(54.0, (WIDTH - left - 10) / max(len(people), 1))
    height = min(cell, 30.0)
    drawing = Drawing(name, WIDTH, top + height * len(owners) + 12, title)
    drawing.text((0, 14), "Scorer of", "f-ink bold", size=12)
    drawing.text((left, 14), "Choices of", "f-ink bold", size=12)
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    turned = cell < 40
    for column, who in enumerate(people):
        x = left + cell * (column + 0.5)
        shown = who[: 6 if turned else 8]
        drawing.text((x, top - 10), shown, "f-ink", "middle", 9.5 if turned else 11.5)
    for row, owner in enumerate(owners):
        y = top + height * row
        drawing.text((0, y + height / 2 + 4), owner[:18], "f-ink", size=12)
        for column, who in enumerate(people):
            value = float(values[row, column])
            corner = (left + cell * column, y)
            if math.isnan(value):
                continue
            share = (value - low) / (high - low) if high > low else 0.5
            drawing.rect(corner, cell - 2, height - 2, f"f-c1 o{round(share * 9)}")
            if len(people) <= MOST_NUMBERS:
                at = (corner[0] + (cell - 2) / 2, y + height / 2 + 3)
                weight = "f-ink bold" if owner == who else "f-ink"
                drawing.text(at, fraction(value), weight, "middle", 11)
            if owner == who:
                drawing.rect(corner, cell - 2, height - 2, "none s-ink medium")
    return drawing


Line = tuple[str, Sequence[tuple[float, float]]]


def parting_panels(
    name: str,
    panels: Sequence[tuple[str, str, Sequence[Line], Sequence[tuple[float, float]]]],
    title: str,
) -> Drawing:
    """Draw agreement along time and along each number of the state, a line for each scorer.

    Args:
        name: unique in the page.
        panels: (title, unit, (scorer, points) of each line, points of chance).
        title: what the figure shows, for those who cannot see it.
    """
    across, width, height = 3, 306.0, 210.0
    rows = (len(panels) + across - 1) // across
    drawing = Drawing(name, WIDTH, rows * height + 26, title)
    reach = [y for _, _, lines, chance in panels for _, y in (*chance, *_points(lines))]
    scale = Scale([0.0, *reach], 168.0, 32.0, ticks=5)
    for place, (heading, unit, lines, chance) in enumerate(panels):
        drawing.open_group(move=(place % across * width, place // across * height))
        panel_title(drawing, 0, "abcdefghijkl"[place % 12], heading, unit)
        vertical_axis(drawing, scale, 40, 286)
        xs = [x for x, _ in (*chance, *_points(lines))]
        along = Scale(xs, 48, 278, ticks=5)
        for tick in along.ticks:
            drawing.text((along(tick), 186), along.label(tick), "f-quiet", "middle", 11)
        drawing.polyline([(along(x), scale(y)) for x, y in chance], "s-quiet dashed")
        for at, (_, points) in enumerate(lines):
            colour = MARKS[at % len(MARKS)]
            drawn = [(along(x), scale(y)) for x, y in points]
            drawing.polyline(drawn, f"s-{colour} medium")
            for point in drawn:
                drawing.circle(point, 2.6, f"f-{colour} s-paper")
        drawing.close_group()
    x, y = 0.0, rows * height + 16
    for at, (scorer, _) in enumerate(panels[0][2]):
        colour = MARKS[at % len(MARKS)]
        drawing.circle((x + 5, y - 4), 4.2, f"f-{colour}")
        drawing.text((x + 15, y), scorer, "f-ink", size=11.5)
        x += 36 + 6.6 * len(scorer)
    drawing.line((x, y - 4), (x + 22, y - 4), "s-quiet dashed")
    drawing.text((x + 28, y), "chance", "f-quiet", size=11.5)
    return drawing


def _points(lines: Sequence[Line]) -> list[tuple[float, float]]:
    return [point for _, points in lines for point in points]
