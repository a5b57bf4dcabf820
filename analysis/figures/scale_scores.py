"""Scores of instruments: each participant's under each condition, with mean and interval."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.figures.paired_means import inferred, mean_interval, swarm
from analysis.figures.svg import Drawing, Scale, round_step, tone
from analysis.formatting import interval, number
from analysis.statistics.scale_scores import ScaleRow

WIDTH = 920.0
LABEL_RIGHT = 300.0
PLOT_LEFT, PLOT_RIGHT = 318.0, 770.0
MEAN_RIGHT = WIDTH
ROW, TOP = 30.0, 34.0
AFTER = 40.0
"""Below the rows of a scale: its axis, and a little air."""
DOT = 3.2
WIDE = 20.0
"""Beyond this range of scores one decimal says enough."""


def score_dots(
    name: str, rows: Sequence[ScaleRow], labels: Sequence[str], headings: Sequence[tuple[str, str]]
) -> Drawing:
    """Draw a row for each scale, occasion and condition; each scale on its own axis.

    Args:
        name: unique in the page.
        rows: the scales on their occasions, with participants in them.
        labels: the conditions' labels.
        headings: for each row its name and, below it, when it was asked.
    """
    heights = [max(len(row.cells.levels), 2) * ROW + AFTER for row in rows]
    title = f"Scores of {len(rows)} scales, each participant's under each condition"
    drawing = Drawing(name, WIDTH, TOP + sum(heights), title)
    drawing.text((0, 14), "Scale", "f-ink bold", size=12)
    middle = (PLOT_LEFT + PLOT_RIGHT) / 2
    drawing.text((middle, 14), "Score of each participant", "f-ink bold", "middle", 12)
    drawing.text((MEAN_RIGHT, 14), "Mean [95% CI]", "f-ink bold", "end", 12)
    drawing.line((0, 24), (WIDTH, 24), "s-ink")
    y = TOP
    for row, (heading, when), height in zip(rows, headings, heights, strict=True):
        drawing.text((0, y + 15), heading, "f-ink bold", size=12)
        drawing.text((0, y + 32), when, "f-quiet", size=11.5)
        shown = labels if row.compared else ["All"]
        _scale(drawing, row, shown, y)
        y += height
    return drawing


def _scale(drawing: Drawing, row: ScaleRow, labels: Sequence[str], top: float) -> None:
    axis = _axis(row)
    low, high = axis[0], axis[-1]
    decimals = 1 if high - low > WIDE else 2

    def scale(value: float) -> float:
        return PLOT_LEFT + (PLOT_RIGHT - PLOT_LEFT) * (value - low) / (high - low)

    bottom = top + len(labels) * ROW
    for tick in axis:
        drawing.line((scale(tick), top), (scale(tick), bottom), "s-rule")
        drawing.text((scale(tick), bottom + 14), f"{tick:g}", "f-quiet", "middle", 11)
    for place, label in enumerate(labels):
        y = top + (place + 0.5) * ROW
        values = row.cells.means[:, place]
        drawing.text((LABEL_RIGHT, y + 4), label, f"t-{tone(place)} bold", "end", 12)
        xs = [scale(value) for value in values]
        for x, shift in zip(xs, swarm(xs, 2 * DOT), strict=True):
            aside = max(-ROW / 2 + DOT, min(ROW / 2 - DOT, shift))
            drawing.circle((x, y + aside), DOT, f"f-{tone(place)} dot")
        mean, bounds = float(np.mean(np.sort(values))), mean_interval(values)
        text = number(mean, decimals)
        if inferred(row.cells):
            ends = (max(scale(bounds.low), PLOT_LEFT), min(scale(bounds.high), PLOT_RIGHT))
            drawing.line((ends[0], y), (ends[1], y), "s-ink thick")
            text += f" {interval(bounds, decimals)}"
        drawing.line((scale(mean), y - 8), (scale(mean), y + 8), "s-ink thick")
        drawing.text((MEAN_RIGHT, y + 4), text, "f-ink", "end", 12)


def _axis(row: ScaleRow) -> list[float]:
    """Return ticks from the least to the largest score possible; round ones about the data else."""
    low, high = row.asked.lowest, row.asked.highest
    if not (np.isfinite(low) and np.isfinite(high) and high > low):
        return Scale(list(row.cells.means.ravel()), 0, 1).ticks
    step = round_step((high - low) / 7)
    ticks = [low + place * step for place in range(int((high - low) / step + 1e-9) + 1)]
    return ticks if high - ticks[-1] < 1e-9 else [*ticks, high]
