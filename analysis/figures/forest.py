"""All models of one difference below each other: estimates with their intervals."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from analysis.figures.svg import Drawing, Scale
from analysis.formatting import interval, number, plain_statistic
from analysis.statistics.result import EffectResult

WIDTH = 920.0
PLOT_LEFT, PLOT_RIGHT = 346.0, 596.0
ESTIMATE_RIGHT, STATISTIC_RIGHT = 742.0, 874.0
ROW, HEAD = 22.0, 26.0
LONGEST_NAME = 56


@dataclasses.dataclass(frozen=True, slots=True)
class ForestGroup:
    """Models under one heading.

    Attributes:
        heading: what they have in common.
        kind: "primary", "sensitivity" or "comparison".
        results: those with an estimate and an interval in the measure's unit.
    """

    heading: str
    kind: str
    results: tuple[EffectResult, ...]


def forest(name: str, groups: Sequence[ForestGroup], labels: Sequence[str]) -> Drawing | None:
    """Draw every model of the difference between two conditions; None if there is none.

    Args:
        name: unique in the page.
        groups: the models; the first result of the first group is the primary one.
        labels: of the two conditions, the reference first; none if rows compare others.
    """
    shown = [group for group in groups if group.results]
    if not shown:
        return None
    rows = sum(len(group.results) for group in shown)
    bottom = 34 + rows * ROW + len(shown) * HEAD
    title = f"Differences of {rows} pairs of conditions with 95% intervals"
    if labels:
        title = f"Differences, {labels[-1]} minus {labels[0]}, of {rows} models with 95% intervals"
    drawing = Drawing(name, WIDTH, bottom + 46, title)
    reach = [r.estimate for g in shown for r in g.results if r.estimate is not None]
    for group in shown:
        for result in group.results:
            if result.interval is not None:
                reach += [result.interval.low, result.interval.high]
    scale = Scale(reach, PLOT_LEFT + 8, PLOT_RIGHT - 8, ticks=7, zero=True)
    _header(drawing, "Model" if labels else "Pair")
    for tick in scale.ticks:
        x = scale(tick)
        drawing.line((x, 28), (x, bottom), "s-ink" if tick == 0 else "s-rule")
        drawing.text((x, bottom + 17), scale.label(tick), "f-quiet", "middle", 11.5)
    if labels:
        under = bottom + 35
        drawing.text((scale(0) - 8, under), f"← {labels[0]} better", "f-quiet", "end", 11.5)
        drawing.text((scale(0) + 8, under), f"{labels[-1]} better →", "f-quiet", "start", 11.5)
    primary = shown[0].results[0].estimate if labels else None
    if primary is not None:
        drawing.line((scale(primary), 28), (scale(primary), bottom), "s-quiet thin-dash")
    y = 34.0
    for group in shown:
        tone = "f-quiet" if group.kind == "comparison" else "f-ink"
        drawing.text((0, y + 15), group.heading, f"{tone} bold", size=12)
        y += HEAD
        for result in group.results:
            _row(drawing, result, group.kind, scale, y + ROW / 2)
            y += ROW
    return drawing


def _header(drawing: Drawing, what: str) -> None:
    middle = (PLOT_LEFT + PLOT_RIGHT) / 2
    drawing.text((0, 14), what, "f-ink bold", size=12)
    drawing.text((middle, 14), "Difference, points", "f-ink bold", "middle", 12)
    drawing.text((ESTIMATE_RIGHT, 14), "Estimate [95% CI]", "f-ink bold", "end", 12)
    drawing.text((STATISTIC_RIGHT, 14), "Statistic", "f-ink bold", "end", 12)
    drawing.text((WIDTH, 14), "Rows", "f-ink bold", "end", 12)
    drawing.line((0, 24), (WIDTH, 24), "s-ink")


def _row(drawing: Drawing, result: EffectResult, kind: str, scale: Scale, y: float) -> None:
    estimate, bounds = result.estimate, result.interval
    if estimate is None or bounds is None:
        return
    muted = kind == "comparison"
    tone = "f-quiet" if muted else "f-ink bold" if kind == "primary" else "f-ink"
    text = result.name
    if len(text) > LONGEST_NAME:
        text = text[: LONGEST_NAME - 1].rstrip() + "…"
    drawing.text((12, y + 4), text, tone, size=12)
    stroke = {"primary": "s-ink thick", "comparison": "s-quiet dashed"}.get(kind, "s-ink medium")
    drawing.line((scale(bounds.low), y), (scale(bounds.high), y), stroke)
    x = scale(estimate)
    if kind == "primary":
        drawing.polygon([(x - 6, y), (x, y - 6), (x + 6, y), (x, y + 6)], "f-ink")
    elif muted:
        drawing.rect((x - 3.5, y - 3.5), 7, 7, "f-paper s-quiet")
    else:
        drawing.rect((x - 3.5, y - 3.5), 7, 7, "f-ink")
    value = f"{number(estimate)} {interval(bounds)}"
    drawing.text((ESTIMATE_RIGHT, y + 4), value, tone, "end", 12)
    drawing.text((STATISTIC_RIGHT, y + 4), plain_statistic(result), tone, "end", 12)
    drawing.text((WIDTH, y + 4), str(result.rows), tone, "end", 12)
