"""Means of crossed factors: a line for each level of the first, and its effect beside it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from analysis.factors import Crossing, Factor
from analysis.figures.paired_means import LINE, inferred, mean_interval, spread_labels, swarm
from analysis.figures.svg import Drawing, Scale, panel_title, tone, vertical_axis
from analysis.formatting import number
from analysis.statistics.cells import Cells

WIDTH, HEIGHT = 920.0, 362.0
TOP, BOTTOM = 32.0, 306.0
SPLIT = 530.0
APART = 9.0
"""Between the marks of two levels at the same place, px."""
WIDE = 74.0
"""A column of differences narrower than this has no room for its own label, px."""

Columns = Mapping[tuple[str, str], np.ndarray]


def interaction(name: str, crossing: Crossing, cells: Cells) -> Drawing:
    """Draw panel a, cell means with intervals, and panel b, the first factor's effect.

    Args:
        name: unique in the page.
        crossing: lines are levels of the first factor, places along x of the second; with three
            factors there are both panels for each level of the third, on the same axes.
        cells: participants' means of every condition of the crossing.
    """
    lines, places = crossing.factors[:2]
    third = crossing.factors[2] if len(crossing.factors) > 2 else None
    title = f"Mean team reward by {' and '.join(f.label.lower() for f in crossing.factors)}"
    strata: list[tuple[str, ...]] = [(level,) for level in third.levels] if third else [()]
    drawing = Drawing(name, WIDTH, HEIGHT * len(strata), title)
    columns = [
        {
            (a, b): cells.column(crossing.condition((a, b, *stratum)))
            for a in lines.levels
            for b in places.levels
        }
        for stratum in strata
    ]
    draws = inferred(cells)
    means, gaps = _mean_scale(columns, draws=draws), _gap_scale(columns, lines, draws=draws)
    for row, (stratum, own) in enumerate(zip(strata, columns, strict=True)):
        drawing.open_group(move=(0.0, HEIGHT * row))
        where = ""
        if third is not None:
            where = f", {third.level_labels[third.levels.index(stratum[0])]}"
        letters = ("", "") if third is not None else ("a", "b")
        panel_title(drawing, 0, letters[0], f"Mean team reward{where}", "points")
        _means(drawing, lines, places, own, means, draws=draws)
        title_b = f"Difference from {lines.level_labels[0].lower()}{where}"
        if len(lines.levels) == 2:
            shown = f"{lines.level_labels[-1].lower()} − {lines.level_labels[0].lower()}"
            title_b = f"Difference, {shown}{where}"
        panel_title(drawing, SPLIT - 20, letters[1], title_b, "points")
        _differences(drawing, lines, places, own, gaps, draws=draws)
        drawing.close_group()
    return drawing


def _mean_scale(columns: list[dict[tuple[str, str], np.ndarray]], *, draws: bool) -> Scale:
    values = [values for own in columns for values in own.values()]
    bounds = [mean_interval(column) for column in values]
    reach = [bound for i in bounds for bound in (i.low, i.high) if draws]
    return Scale([*(float(np.mean(column)) for column in values), *reach], BOTTOM, TOP)


def _gap_scale(
    columns: list[dict[tuple[str, str], np.ndarray]], lines: Factor, *, draws: bool
) -> Scale:
    found = [
        values - own[lines.levels[0], b]
        for own in columns
        for (a, b), values in own.items()
        if a != lines.levels[0]
    ]
    reach = [bound for i in map(mean_interval, found) for bound in (i.low, i.high) if draws]
    return Scale([*np.concatenate(found), *reach], BOTTOM, TOP, zero=True)


def _places(left: float, right: float, count: int) -> list[float]:
    slot = (right - left) / count
    return [left + slot * (place + 0.5) for place in range(count)]


def _means(
    drawing: Drawing, lines: Factor, places: Factor, columns: Columns, scale: Scale, *, draws: bool
) -> None:
    left, right = 42.0, SPLIT - 140
    vertical_axis(drawing, scale, left, right)
    xs = _places(left, right, len(places.levels))
    ends = []
    for index, a in enumerate(lines.levels):
        shift = APART * (index - (len(lines.levels) - 1) / 2)
        middles = [float(np.mean(np.sort(columns[a, b]))) for b in places.levels]
        points = [(x + shift, scale(mean)) for x, mean in zip(xs, middles, strict=True)]
        drawing.polyline(points, f"s-{tone(index)} medium")
        for (x, y), b in zip(points, places.levels, strict=True):
            if draws:
                bounds = mean_interval(columns[a, b])
                low, high = (x, scale(bounds.low)), (x, scale(bounds.high))
                drawing.line(low, high, f"s-{tone(index)} thick")
            drawing.circle((x, y), 5, f"f-{tone(index)} s-paper")
        ends.append((points[-1][1], f"{tone(index)} {lines.level_labels[index]}"))
    for y, text in spread_labels(ends, LINE + 4):
        level, _, label = text.partition(" ")
        drawing.text((right + 8, y + 4), label, f"t-{level} bold", size=12.5)
    _place_labels(drawing, places, xs, (left + right) / 2)


def _differences(
    drawing: Drawing, lines: Factor, places: Factor, columns: Columns, scale: Scale, *, draws: bool
) -> None:
    left, right = SPLIT + 22, WIDTH
    vertical_axis(drawing, scale, left, right, signed=True)
    drawing.line((left, scale(0)), (right, scale(0)), "s-ink")
    xs = _places(left, right, len(places.levels))
    others = list(enumerate(lines.levels))[1:]
    slot = (right - left) / len(places.levels) / len(others)
    for x, b in zip(xs, places.levels, strict=True):
        for index, a in others:
            middle = x + slot * (index - 1 - (len(others) - 1) / 2)
            level = tone(index) if len(others) > 1 else ""
            values = columns[a, b] - columns[lines.levels[0], b]
            _column(drawing, values, scale, middle, slot, level, draws=draws)
            if len(others) > 1 and slot >= WIDE:
                drawing.text(
                    (middle, BOTTOM + 12),
                    lines.level_labels[index],
                    f"t-{tone(index)}",
                    "middle",
                    11,
                )
    _place_labels(drawing, places, xs, (left + right) / 2)


def _column(
    drawing: Drawing,
    values: np.ndarray,
    scale: Scale,
    middle: float,
    slot: float,
    level: str,
    *,
    draws: bool,
) -> None:
    """Draw each participant's difference with mean and interval beside; coloured by its level."""
    fill, stroke, text_tone = (
        (f"f-{level} dot", f"s-{level} thick", f"t-{level}")
        if level
        else ("f-soft s-paper", "s-ink thick", "f-ink")
    )
    ys = [scale(v) for v in values]
    narrow = slot < WIDE
    reach = slot * 0.28
    for y, aside in zip(ys, swarm(ys, 6.0 if narrow else 9.0), strict=True):
        x = middle - slot * 0.2 + max(-reach, min(reach, aside))
        drawing.circle((x, y), 2.4 if narrow else 3.6, fill)
    mean, bounds = float(np.mean(np.sort(values))), mean_interval(values)
    beside = middle + slot * 0.14
    if draws:
        drawing.line((beside, scale(bounds.low)), (beside, scale(bounds.high)), stroke)
    drawing.line((beside - 5, scale(mean)), (beside + 5, scale(mean)), stroke)
    text = ("+" if round(mean, 1) > 0 else "") + number(mean, 1)
    if level:  # the next column begins where the text would stand
        top = scale(bounds.high) if draws else scale(mean)
        drawing.text((beside, top - 6), text, f"{text_tone} bold halo", "middle", 11.5)
    else:
        drawing.text((beside + 8, scale(mean) + 4), text, f"{text_tone} bold halo", size=11.5)


def _place_labels(drawing: Drawing, places: Factor, xs: list[float], middle: float) -> None:
    for x, label in zip(xs, places.level_labels, strict=True):
        drawing.text((x, BOTTOM + 27), label, "f-ink bold", "middle", 12.5)
    drawing.text((middle, BOTTOM + 45), places.label, "f-quiet", "middle", 11.5)
