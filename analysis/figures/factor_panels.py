"""Small panels of cell means, one an item or scale: a line for each level of the first factor."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from analysis.factors import Crossing
from analysis.figures.paired_means import inferred, mean_interval
from analysis.figures.svg import Drawing, round_step, tone
from analysis.statistics.cells import Cells

WIDTH = 920.0
COLUMNS = 4
KEY, PANEL = 34.0, 228.0
TOP, BOTTOM = 46.0, 178.0
"""Of the axes within a panel, px."""
APART = 6.0


@dataclasses.dataclass(frozen=True, slots=True)
class Panel:
    """What one panel shows.

    Attributes:
        heading: the item or scale.
        under: when it was asked, or which level of a third factor.
        cells: participants' answers or scores; every condition of the crossing.
        low, high: ends of the axis: the least and the largest value possible.
        third: level of a third factor; empty with two.
    """

    heading: str
    under: str
    cells: Cells
    low: float
    high: float
    third: str = ""


def factor_panels(name: str, title: str, crossing: Crossing, panels: Sequence[Panel]) -> Drawing:
    """Draw the panels, four in a row, under a key of the first factor's levels.

    Args:
        name: unique in the page.
        title: what the image shows.
        crossing: lines are levels of the first factor, places along x of the second.
        panels: in order, each with someone in it.
    """
    columns = min(COLUMNS, max(len(panels), 2))
    rows = -(-len(panels) // columns)
    drawing = Drawing(name, WIDTH, KEY + rows * PANEL, title)
    lines = crossing.factors[0]
    x = 0.0
    drawing.text((x, 14), f"{lines.label}:", "f-ink bold", size=12)
    x += 8.0 * len(lines.label) + 16
    for index, label in enumerate(lines.level_labels):
        drawing.line((x, 10), (x + 20, 10), f"s-{tone(index)} thick")
        drawing.circle((x + 10, 10), 4, f"f-{tone(index)} s-paper")
        drawing.text((x + 26, 14), label, f"t-{tone(index)} bold", size=12)
        x += 26 + 7.4 * len(label) + 22
    width = WIDTH / columns
    for place, panel in enumerate(panels):
        drawing.open_group(move=(width * (place % columns), KEY + PANEL * (place // columns)))
        _panel(drawing, crossing, panel, width - 24)
        drawing.close_group()
    return drawing


def spread_panels(crossing: Crossing, panel: Panel) -> list[Panel]:
    """Return a panel for each level of a third factor; the panel itself where there is none."""
    if len(crossing.factors) < 3:
        return [panel]
    third = crossing.factors[2]
    return [
        dataclasses.replace(panel, under=f"{panel.under}, {label}", third=level)
        for level, label in zip(third.levels, third.level_labels, strict=True)
    ]


def _panel(drawing: Drawing, crossing: Crossing, panel: Panel, width: float) -> None:
    lines, places = crossing.factors[:2]
    drawing.text((0, 12), panel.heading, "f-ink bold", size=12)
    drawing.text((0, 28), panel.under, "f-quiet", size=11)
    left, right = 30.0, width

    def scale(value: float) -> float:
        return BOTTOM - (BOTTOM - TOP) * (value - panel.low) / (panel.high - panel.low)

    step = round_step((panel.high - panel.low) / 6)
    count = int((panel.high - panel.low) / step + 1e-9) + 1
    for tick in (panel.low + step * place for place in range(count)):
        drawing.line((left, scale(tick)), (right, scale(tick)), "s-rule")
        drawing.text((left - 8, scale(tick) + 4), f"{tick:g}", "f-quiet", "end", 11)
    slot = (right - left) / len(places.levels)
    xs = [left + slot * (place + 0.5) for place in range(len(places.levels))]
    rest = (panel.third,) if panel.third else ()
    for index, a in enumerate(lines.levels):
        shift = APART * (index - (len(lines.levels) - 1) / 2)
        own = [panel.cells.column(crossing.condition((a, b, *rest))) for b in places.levels]
        points = [
            (x + shift, scale(float(np.mean(np.sort(v))))) for x, v in zip(xs, own, strict=True)
        ]
        drawing.polyline(points, f"s-{tone(index)} medium")
        for (x, y), values in zip(points, own, strict=True):
            if inferred(panel.cells):
                bounds = mean_interval(values)
                ends = (max(bounds.low, panel.low), min(bounds.high, panel.high))
                drawing.line((x, scale(ends[0])), (x, scale(ends[1])), f"s-{tone(index)} medium")
            drawing.circle((x, y), 4, f"f-{tone(index)} s-paper")
    for x, label in zip(xs, places.level_labels, strict=True):
        drawing.text((x, BOTTOM + 20), label, "f-ink", "middle", 11)
