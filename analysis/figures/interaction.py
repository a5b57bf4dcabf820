"""Means of two crossed factors: a line for each level of the first, and its effect beside it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from analysis.factors import Crossing, Factor
from analysis.figures.paired_means import LINE, inferred, mean_interval, spread_labels, swarm
from analysis.figures.svg import Drawing, Scale, panel_title, vertical_axis
from analysis.formatting import number
from analysis.statistics.cells import Cells

WIDTH, HEIGHT = 920.0, 362.0
TOP, BOTTOM = 32.0, 306.0
SPLIT = 530.0
APART = 9.0
"""Between the marks of two levels at the same place, px."""


def interaction(name: str, crossing: Crossing, cells: Cells) -> Drawing:
    """Draw panel a, cell means with intervals, and panel b, the first factor's effect.

    Args:
        name: unique in the page.
        crossing: two factors: lines are levels of the first, places along x of the second.
        cells: participants' means of every condition of the crossing.
    """
    lines, places = crossing.factors
    title = f"Mean team reward by {lines.label.lower()} and {places.label.lower()}"
    drawing = Drawing(name, WIDTH, HEIGHT, title)
    columns = {
        (a, b): cells.column(crossing.condition((a, b)))
        for a in lines.levels
        for b in places.levels
    }
    panel_title(drawing, 0, "a", "Mean team reward per trial", "points")
    _means(drawing, lines, places, columns, draws=inferred(cells))
    shown = f"{lines.level_labels[-1].lower()} − {lines.level_labels[0].lower()}"
    panel_title(drawing, SPLIT - 20, "b", f"Difference, {shown}", "points")
    _differences(drawing, lines, places, columns, draws=inferred(cells))
    return drawing


Columns = Mapping[tuple[str, str], np.ndarray]


def _places(left: float, right: float, count: int) -> list[float]:
    slot = (right - left) / count
    return [left + slot * (place + 0.5) for place in range(count)]


def _means(
    drawing: Drawing, lines: Factor, places: Factor, columns: Columns, *, draws: bool
) -> None:
    left, right = 42.0, SPLIT - 140
    intervals = {key: mean_interval(column) for key, column in columns.items()}
    reach = [bound for i in intervals.values() for bound in (i.low, i.high) if draws]
    middles = {key: float(np.mean(np.sort(column))) for key, column in columns.items()}
    scale = Scale([*middles.values(), *reach], BOTTOM, TOP)
    vertical_axis(drawing, scale, left, right)
    xs = _places(left, right, len(places.levels))
    ends = []
    for index, a in enumerate(lines.levels):
        shift = APART * (index - (len(lines.levels) - 1) / 2)
        points = [(x + shift, scale(middles[a, b])) for x, b in zip(xs, places.levels, strict=True)]
        drawing.polyline(points, f"s-c{index} medium")
        for (x, y), b in zip(points, places.levels, strict=True):
            if draws:
                bounds = intervals[a, b]
                low, high = (x, scale(bounds.low)), (x, scale(bounds.high))
                drawing.line(low, high, f"s-c{index} thick")
            drawing.circle((x, y), 5, f"f-c{index} s-paper")
        ends.append((points[-1][1], f"{index} {lines.level_labels[index]}"))
    for y, text in spread_labels(ends, LINE + 4):
        place, _, label = text.partition(" ")
        drawing.text((right + 8, y + 4), label, f"t-c{place} bold", size=12.5)
    for x, label in zip(xs, places.level_labels, strict=True):
        drawing.text((x, BOTTOM + 24), label, "f-ink bold", "middle", 12.5)
    drawing.text(((left + right) / 2, BOTTOM + 43), places.label, "f-quiet", "middle", 11.5)


def _differences(
    drawing: Drawing, lines: Factor, places: Factor, columns: Columns, *, draws: bool
) -> None:
    left, right = SPLIT + 22, WIDTH
    first, last = lines.levels[0], lines.levels[-1]
    found = [columns[last, b] - columns[first, b] for b in places.levels]
    intervals = [mean_interval(values) for values in found]
    reach = [bound for i in intervals for bound in (i.low, i.high) if draws]
    scale = Scale([*np.concatenate(found), *reach], BOTTOM, TOP, zero=True)
    vertical_axis(drawing, scale, left, right, signed=True)
    drawing.line((left, scale(0)), (right, scale(0)), "s-ink")
    xs = _places(left, right - 30, len(places.levels))
    labels = zip(xs, found, intervals, places.level_labels, strict=True)
    for x, values, bounds, label in labels:
        for value, aside in zip(values, swarm([scale(v) for v in values], 9.0), strict=True):
            drawing.circle((x - 14 + aside, scale(value)), 3.6, "f-soft s-paper")
        mean = float(np.mean(np.sort(values)))
        beside = x + 22
        if draws:
            drawing.line((beside, scale(bounds.low)), (beside, scale(bounds.high)), "s-ink thick")
        drawing.line((beside - 6, scale(mean)), (beside + 6, scale(mean)), "s-ink thick")
        text = ("+" if round(mean, 1) > 0 else "") + number(mean, 1)
        drawing.text((beside + 10, scale(mean) + 4), text, "f-ink bold halo", size=11.5)
        drawing.text((x, BOTTOM + 24), label, "f-ink bold", "middle", 12.5)
    drawing.text(((left + right) / 2, BOTTOM + 43), places.label, "f-quiet", "middle", 11.5)
