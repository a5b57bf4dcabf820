"""Checks of the primary test: normal quantiles, leave one out, residuals of the trials."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import special, stats

from analysis.figures.paired_means import mean_interval
from analysis.figures.svg import Drawing, Scale, panel_title, tone, vertical_axis
from analysis.statistics.result import Interval

WIDTH = 920.0
TOP, BOTTOM = 34.0, 236.0
MOST_ROWS = 40
"""Above so many participants the panel of left-out participants names only some of them."""

Floats = npt.NDArray[np.float64]


def check_panels(
    name: str,
    differences: Floats,
    participants: Sequence[str],
    without: Sequence[tuple[float, Interval]],
    fitted: Floats,
    residuals: Floats,
    conditions: npt.NDArray[np.int64],
    labels: Sequence[str],
) -> Drawing:
    """Draw the three panels.

    Args:
        name: unique in the page.
        differences: one for each participant, shape (n,).
        participants: whose they are.
        without: estimate and 95 % interval without each participant, in their order; empty if
            too few would be left.
        fitted: mean of each trial's participant and condition, shape (trials,).
        residuals: what each trial is above it, shape (trials,).
        conditions: each trial's condition by place in ``labels``, shape (trials,).
        labels: the conditions' labels.
    """
    rows = min(len(participants), MOST_ROWS)
    bottom = max(BOTTOM, TOP + 14.0 * rows)
    text = "Checks: differences against a normal, without one participant, residuals of the trials"
    drawing = Drawing(name, WIDTH, bottom + 46, text)
    _quantiles(drawing, differences, participants, bottom)
    _leave_one_out(drawing, differences, participants, without, bottom)
    _residuals(drawing, fitted, residuals, conditions, labels, bottom)
    return drawing


def normal_scores(n: int) -> Floats:
    """Return the median of each order statistic of n standard normal values, shape (n,)."""
    places = np.arange(1, n + 1)
    return np.asarray(stats.norm.ppf(stats.beta.ppf(0.5, places, n + 1 - places)))


def envelope(n: int) -> tuple[Floats, Floats]:
    """Return the pointwise 95 % band of n ordered standard normal values.

    The k-th of n ordered uniform values has the beta distribution B(k, n + 1 - k).
    """
    places = np.arange(1, n + 1)
    low = stats.norm.ppf(special.betaincinv(places, n + 1 - places, 0.025))
    high = stats.norm.ppf(special.betaincinv(places, n + 1 - places, 0.975))
    return np.asarray(low), np.asarray(high)


def _quantiles(
    drawing: Drawing, differences: Floats, participants: Sequence[str], bottom: float
) -> None:
    n = differences.size
    order = np.argsort(differences, kind="stable")
    ordered, scores = differences[order], normal_scores(n)
    mean, sd = float(np.mean(ordered)), float(np.std(ordered, ddof=1))
    low, high = (mean + sd * bound for bound in envelope(n))
    left, right = 38.0, 250.0
    panel_title(drawing, 0, "a", "Differences against a normal", "")
    y = Scale([*ordered, *low, *high], bottom, TOP, ticks=6)
    x = Scale([*scores], left + 8, right - 8, ticks=4)
    vertical_axis(drawing, y, left, right)
    upper = [(x(s), y(v)) for s, v in zip(scores, high, strict=True)]
    lower = [(x(s), y(v)) for s, v in zip(scores[::-1], low[::-1], strict=True)]
    drawing.polygon([*upper, *lower], "f-soft band")
    ends = (float(scores[0]), float(scores[-1]))
    drawing.line(
        (x(ends[0]), y(mean + sd * ends[0])),
        (x(ends[1]), y(mean + sd * ends[1])),
        "s-quiet thin-dash",
    )
    for score, value in zip(scores, ordered, strict=True):
        drawing.circle((x(score), y(value)), 3.6, "f-soft s-paper")
    outside = [place for place in range(n) if not low[place] <= ordered[place] <= high[place]]
    for place in outside[:3]:
        who = participants[int(order[place])]
        drawing.text((x(scores[place]) + 7, y(ordered[place]) + 4), who, "f-ink", size=11.5)
    _bottom_axis(drawing, x, bottom, "Normal quantile", (left + right) / 2)


def _leave_one_out(
    drawing: Drawing,
    differences: Floats,
    participants: Sequence[str],
    without: Sequence[tuple[float, Interval]],
    bottom: float,
) -> None:
    left, right = 372.0, 570.0
    panel_title(drawing, 312, "b", "Without one participant", "")
    if not without:
        drawing.text((left, TOP + 24), "Too few would be left.", "f-quiet", size=11.5)
        return
    whole = mean_interval(differences)
    if len(without) > MOST_ROWS:
        # The two ends and an even choice between them stand for all.
        by_estimate = sorted(range(len(without)), key=lambda place: without[place][0])
        chosen = np.linspace(0, len(without) - 1, MOST_ROWS).astype(int)
        places = sorted({by_estimate[place] for place in chosen})
    else:
        places = list(range(len(without)))
    reach = [end for place in places for end in (without[place][1].low, without[place][1].high)]
    x = Scale([*reach, whole.low, whole.high], left, right, ticks=4, zero=True)
    drawing.rect((x(whole.low), TOP), x(whole.high) - x(whole.low), bottom - TOP, "f-soft band")
    mean = x(float(np.mean(differences)))
    drawing.line((mean, TOP), (mean, bottom), "s-quiet thin-dash")
    drawing.line((x(0), TOP), (x(0), bottom), "s-ink")
    step = (bottom - TOP) / max(len(places), 1)
    for row, place in enumerate(places):
        estimate, bounds = without[place]
        y = TOP + step * (row + 0.5)
        drawing.text((left - 10, y + 4), participants[place][:9], "f-quiet", "end", 11)
        drawing.line((x(bounds.low), y), (x(bounds.high), y), "s-soft")
        drawing.circle((x(estimate), y), 3.2, "f-soft s-paper")
    _bottom_axis(drawing, x, bottom, "Difference, points", (left + right) / 2)


def _residuals(
    drawing: Drawing,
    fitted: Floats,
    residuals: Floats,
    conditions: npt.NDArray[np.int64],
    labels: Sequence[str],
    bottom: float,
) -> None:
    left, right = 666.0, WIDTH
    panel_title(drawing, 630, "c", f"Residuals of {residuals.size} trials", "")
    y = Scale(list(residuals), bottom, TOP, ticks=5, zero=True)
    x = Scale(list(fitted), left + 8, right - 8, ticks=4)
    vertical_axis(drawing, y, left, right)
    drawing.line((left, y(0)), (right, y(0)), "s-ink")
    for value, residual, place in zip(fitted, residuals, conditions, strict=True):
        drawing.circle((x(value), y(residual)), 2.4, f"f-{tone(place)} dot")
    for place, text in enumerate(labels):
        drawing.text((left + 6 + 86 * place, TOP - 4), text[:12], f"t-{tone(place)} bold", size=11)
    _bottom_axis(drawing, x, bottom, "Fitted, points", (left + right) / 2)


def _bottom_axis(drawing: Drawing, x: Scale, bottom: float, title: str, middle: float) -> None:
    for tick in x.ticks:
        drawing.text((x(tick), bottom + 18), x.label(tick), "f-quiet", "middle", 11.5)
    drawing.text((middle, bottom + 37), title, "f-quiet", "middle", 11.5)


def trial_residuals(
    cells: Sequence[tuple[str, str, float]],
) -> tuple[Floats, Floats]:
    """Return each trial's participant-by-condition mean and what it is above it.

    Args:
        cells: (participant, condition, reward) of each trial.

    Returns:
        Fitted values and residuals, both of shape (trials,).
    """
    groups: dict[tuple[str, str], list[float]] = {}
    for who, condition, reward in cells:
        groups.setdefault((who, condition), []).append(reward)
    means = {key: math.fsum(values) / len(values) for key, values in groups.items()}
    fitted = np.array([means[who, condition] for who, condition, _ in cells], dtype=np.float64)
    rewards = np.array([reward for _, _, reward in cells], dtype=np.float64)
    return fitted, rewards - fitted
