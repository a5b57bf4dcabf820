"""Each participant's means joined across conditions, with the differences beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy import stats

from analysis.figures.svg import Drawing, Scale, panel_title, tone, vertical_axis, wrapped
from analysis.formatting import number
from analysis.statistics.cells import Cells
from analysis.statistics.pairs import SMALLEST_N
from analysis.statistics.result import Interval

HEIGHT = 372.0
TOP, BOTTOM = 32.0, 306.0
WIDTH = 920.0
SPLIT = 545.0
MOST_NAMES = 4
INSET = 80.0
"""From the sides of panel a to its outer conditions, px."""
LINE = 13.0
"""From one label's line to the next, px."""


def paired_means(
    name: str,
    cells: Cells,
    labels: Sequence[str],
    hints: Sequence[str],
    *,
    measure: str,
    unit: str,
) -> Drawing:
    """Draw panel a, means joined, and panel b, differences from the reference.

    Args:
        name: unique in the page.
        cells: participant-by-condition means, the reference first.
        labels: the conditions' labels.
        hints: a few words under each label.
        measure: title of panel a.
        unit: unit and what is averaged.
    """
    title = f"{measure} of {_people(cells)} under {' and '.join(labels)}, joined; differences"
    several = len(labels) > 2
    # Two conditions stand side by side; more need the width for themselves, one below the other.
    slot = (WIDTH - 42 - 2 * INSET) / max(len(labels) - 1, 1) - 8
    more = LINE * max(len(wrapped(label, slot, 12.5)) - 1 for label in labels) if several else 0.0
    drawing = Drawing(name, WIDTH, 2 * (HEIGHT + more) if several else HEIGHT, title)
    panel_title(drawing, 0, "a", measure, unit)
    _means(drawing, cells, labels, hints, WIDTH if several else SPLIT - 75)
    reference = labels[0].lower()
    others = "others" if several else labels[-1].lower()
    left = 0.0 if several else SPLIT - 20
    drawing.open_group(move=(0.0, HEIGHT + more if several else 0.0))
    panel_title(drawing, left, "b", f"Difference, {others} − {reference}", "points")
    _differences(drawing, cells, labels, left + 42)
    drawing.close_group()
    return drawing


def _means(
    drawing: Drawing, cells: Cells, labels: Sequence[str], hints: Sequence[str], right: float
) -> None:
    left, several = 42.0, len(labels) > 2
    intervals = [mean_interval(column) for column in cells.means.T]
    reach = [bound for i in intervals for bound in (i.low, i.high) if inferred(cells)]
    scale = Scale([*cells.means.ravel(), *reach], BOTTOM, TOP)
    vertical_axis(drawing, scale, left, right)
    k = len(labels)
    xs = [left + INSET + (right - left - 2 * INSET) * place / (k - 1) for place in range(k)]
    falls = [not several and row[-1] < row[0] for row in cells.means]
    for row, down in zip(cells.means, falls, strict=True):
        points = [(x, scale(value)) for x, value in zip(xs, row, strict=True)]
        drawing.polyline(points, "s-ink dashed" if down else "s-soft")
    for place, x in enumerate(xs):
        for value in cells.means[:, place]:
            drawing.circle((x, scale(value)), 3.2, f"f-{tone(place)} s-paper")
    if sum(falls) <= MOST_NAMES:
        ends = [
            (scale(r[-1]), p)
            for r, p, d in zip(cells.means, cells.participants, falls, strict=True)
            if d
        ]
        for y, participant in spread_labels(ends, LINE):
            drawing.text((xs[-1] + 8, y + 4), participant, "f-ink", size=11.5)
    for place, (x, interval) in enumerate(zip(xs, intervals, strict=True)):
        mean = float(np.mean(cells.means[:, place]))
        side = -22.0 if place == 0 else 22.0 if several else 52.0
        if inferred(cells):
            low, high = (x + side, scale(interval.low)), (x + side, scale(interval.high))
            drawing.line(low, high, f"s-{tone(place)} thick")
        drawing.circle((x + side, scale(mean)), 5, f"f-{tone(place)} s-paper")
        anchor = "end" if place == 0 else "start"
        shift = -9.0 if place == 0 else 9.0
        value = number(mean, 1)
        at = (x + side + shift, scale(mean) + 4)
        drawing.text(at, value, f"t-{tone(place)} bold halo", anchor, 12.5)
        slot = (xs[1] - xs[0] if k > 1 else right) - 8
        lines = wrapped(labels[place], slot, 12.5) if several else [labels[place]]
        for row, line in enumerate(lines):
            y = BOTTOM + 24 + LINE * row
            drawing.text((x, y), line, f"t-{tone(place)} bold", "middle", 12.5)
        y = BOTTOM + 41 + LINE * (len(lines) - 1)
        drawing.text((x, y), hints[place], "f-quiet", "middle", 11.5)


def _differences(drawing: Drawing, cells: Cells, labels: Sequence[str], left: float) -> None:
    right = WIDTH
    differences = cells.means[:, 1:] - cells.means[:, :1]
    intervals = [mean_interval(column) for column in differences.T]
    reach = [bound for i in intervals for bound in (i.low, i.high) if inferred(cells)]
    scale = Scale([*differences.ravel(), *reach], BOTTOM, TOP, zero=True)
    vertical_axis(drawing, scale, left, right, signed=True)
    drawing.line((left, scale(0)), (right, scale(0)), "s-ink")
    columns = differences.shape[1]
    if columns == 1:
        drawing.text((right, scale(0) - 5), "no difference", "f-quiet", "end", 11)
    slot = (right - left - 30) / columns
    for place, interval in enumerate(intervals):
        middle = left + slot * (place + (0.3 if columns == 1 else 0.42))
        values = differences[:, place]
        for value, shift in zip(values, swarm([scale(v) for v in values], 9.0), strict=True):
            drawing.circle((middle + shift, scale(value)), 3.6, "f-soft s-paper")
        x = left + slot * 0.62 if columns == 1 else middle + 50
        mean = float(np.mean(values))
        if inferred(cells):
            drawing.line((x, scale(interval.low)), (x, scale(interval.high)), "s-ink thick")
        drawing.line((x - 7, scale(mean)), (x + 7, scale(mean)), "s-ink thick")
        # The ends of a narrow interval make room for the mean between them.
        marks = [
            (min(scale(interval.high), scale(mean) - LINE), interval.high, ""),
            (scale(mean), mean, "bold"),
            (max(scale(interval.low), scale(mean) + LINE), interval.low, ""),
        ]
        for y, value, weight in marks if inferred(cells) else marks[1:2]:
            text = scale.label(0) if round(value, 1) == 0 else f"{value:+.1f}".replace("-", "−")
            drawing.text((x + 14, y + 4), text, f"f-ink {weight}", size=11.5)
        who = _people(cells) if columns == 1 else labels[place + 1]
        under = middle if columns == 1 else middle + 25
        for row, line in enumerate(wrapped(who, slot - 8, 12) if columns > 1 else [who]):
            drawing.text((under, BOTTOM + 24 + LINE * row), line, "f-ink bold", "middle", 12)
        shown = "Mean, 95% CI" if inferred(cells) else "Mean"
        if columns == 1:
            drawing.text((x + 8, BOTTOM + 24), shown, "f-ink bold", "middle", 12)


def inferred(cells: Cells) -> bool:
    """Whether intervals are drawn: not of so few participants that every test is refused."""
    return cells.n >= SMALLEST_N


def _people(cells: Cells) -> str:
    return f"{cells.n} participant{'' if cells.n == 1 else 's'}"


def mean_interval(values: Sequence[float] | np.ndarray) -> Interval:
    """Return the t interval of a mean; of no width for a single value."""
    sample = np.asarray(values, dtype=np.float64)
    mean = float(np.mean(sample))
    if sample.size < 2:
        return Interval(mean, mean)
    error = float(np.std(sample, ddof=1)) / math.sqrt(sample.size)
    reach = float(stats.t.ppf(0.975, sample.size - 1)) * error
    return Interval(mean - reach, mean + reach)


def swarm(ys: Sequence[float], gap: float) -> list[float]:
    """Shift marks sideways until none overlap; returns the shifts, in the order given."""
    shifts = [0.0] * len(ys)
    placed: list[tuple[float, float]] = []
    for place in sorted(range(len(ys)), key=lambda index: ys[index]):
        for attempt in range(len(ys) + 1):
            shift = gap * ((attempt + 1) // 2) * (-1 if attempt % 2 else 1)
            if all(math.hypot(ys[place] - y, shift - x) >= gap - 1e-9 for y, x in placed):
                break
        shifts[place] = shift
        placed.append((ys[place], shift))
    return shifts


def spread_labels(labels: Sequence[tuple[float, str]], gap: float) -> list[tuple[float, str]]:
    """Move labels apart downwards until each has its line."""
    moved: list[tuple[float, str]] = []
    for y, text in sorted(labels):
        lowest = moved[-1][0] + gap if moved else y
        moved.append((max(y, lowest), text))
    return moved
