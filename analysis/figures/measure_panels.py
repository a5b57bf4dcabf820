"""Small panels, one a measure: each participant's means joined across conditions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.figures.paired_means import inferred, mean_interval
from analysis.figures.svg import Drawing, Scale, vertical_axis
from analysis.statistics.cells import Cells

WIDTH = 920.0
ACROSS = 4
PANEL_WIDTH, PANEL_HEIGHT = 230.0, 214.0
LEFT, RIGHT = 44.0, 208.0
TOP, BOTTOM = 44.0, 186.0
LEGEND = 26.0
COLOURS = 6


def measure_panels(
    name: str, panels: Sequence[tuple[str, str, Cells]], labels: Sequence[str], title: str
) -> Drawing:
    """Draw a panel for each measure, its conditions side by side in the order of the labels.

    Args:
        name: unique in the page.
        panels: (title, unit, participants' means) of each measure, with participants in them.
        labels: the conditions' labels.
        title: what the figure shows, for those who cannot see it.
    """
    rows = (len(panels) + ACROSS - 1) // ACROSS
    drawing = Drawing(name, WIDTH, rows * PANEL_HEIGHT + LEGEND, title)
    for place, (heading, unit, cells) in enumerate(panels):
        at = (place % ACROSS * PANEL_WIDTH, place // ACROSS * PANEL_HEIGHT)
        drawing.open_group(move=at)
        drawing.text((0, 14), "abcdefghijklmnop"[place % 16], "f-ink bold", size=12.5)
        drawing.text((14, 14), heading, "f-ink bold", size=12)
        drawing.text((14, 30), unit, "f-quiet", size=11)
        _panel(drawing, cells)
        drawing.close_group()
    x, y = 14.0, rows * PANEL_HEIGHT + LEGEND - 10
    for place, label in enumerate(labels):
        drawing.circle((x, y - 4), 4.6, f"f-c{place % COLOURS}")
        drawing.text((x + 11, y), label, f"t-c{place % COLOURS} bold", size=12)
        x += 34 + 7.0 * len(label)
    return drawing


def _panel(drawing: Drawing, cells: Cells) -> None:
    intervals = [mean_interval(column) for column in cells.means.T]
    reach = [end for each in intervals for end in (each.low, each.high) if inferred(cells)]
    scale = Scale([*cells.means.ravel(), *reach], BOTTOM, TOP, ticks=4)
    vertical_axis(drawing, scale, LEFT, RIGHT)
    count = len(cells.levels)
    step = (RIGHT - LEFT) / count
    xs = [LEFT + (place + 0.5) * step for place in range(count)]
    for row in cells.means:
        drawing.polyline([(x, scale(value)) for x, value in zip(xs, row, strict=True)], "s-soft")
    for place, x in enumerate(xs):
        colour = f"c{place % COLOURS}"
        for value in cells.means[:, place]:
            drawing.circle((x, scale(value)), 2.4, f"f-{colour} dot")
        mean = float(np.mean(np.sort(cells.means[:, place])))
        side = x + min(16.0, step / 3)
        if inferred(cells):
            ends = intervals[place]
            drawing.line((side, scale(ends.low)), (side, scale(ends.high)), f"s-{colour} thick")
        drawing.circle((side, scale(mean)), 4.2, f"f-{colour} s-paper")
