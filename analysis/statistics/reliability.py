"""Reliability of a scored instrument: Cronbach's alpha with Feldt's interval."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
from scipy import stats

from analysis.statistics.result import Interval, Refusal


@dataclasses.dataclass(frozen=True, slots=True)
class Reliability:
    """How well the items of an instrument agree.

    Attributes:
        name: the instrument.
        alpha: Cronbach's alpha.
        interval: Feldt's 95 % interval.
        without_item: alpha with each item left out, by item; empty with two items.
        items: items used.
        participants: number of rows used, one a participant.
    """

    name: str
    alpha: float
    interval: Interval
    without_item: dict[str, float]
    items: tuple[str, ...]
    participants: int

    @property
    def rows(self) -> int:
        """Answers used: one for each participant and item."""
        return self.participants * len(self.items)


def cronbach_alpha(
    scores: npt.NDArray[np.float64], items: tuple[str, ...], name: str, level: float = 0.95
) -> Reliability | Refusal:
    """Compute alpha of complete answers; reverse-scored items must already be reversed.

    Sources: Cronbach (1951), Psychometrika 16, 297-334; Feldt, Woodruff & Salih (1987),
    Applied Psychological Measurement 11, 93-103.

    Args:
        scores: shape (participants, items), under one condition and occasion.
        items: names, in the order of the columns.
        name: the instrument.
        level: of confidence.
    """
    n, k = scores.shape
    if k < 2:
        return Refusal(name, "Reliability needs at least two items.")
    if n < 3:
        return Refusal(name, f"Reliability needs at least 3 participants; there are {n}.")
    if not np.isfinite(scores).all():
        return Refusal(name, "An answer is missing or not a finite number.")
    if np.ptp(scores.sum(axis=1)) == 0:
        return Refusal(name, "Every participant has the same total, so that nothing varies.")
    alpha = _alpha(scores)
    tail = (1 - level) / 2
    df1, df2 = n - 1, (n - 1) * (k - 1)
    low = 1 - (1 - alpha) * float(stats.f.ppf(1 - tail, df1, df2))
    high = 1 - (1 - alpha) * float(stats.f.ppf(tail, df1, df2))
    without = {}
    for place, item in enumerate(items if k > 2 else ()):
        rest = np.delete(scores, place, axis=1)
        if np.ptp(rest.sum(axis=1)) > 0:
            without[item] = _alpha(rest)
    return Reliability(name, alpha, Interval(low, high, level), without, items, n)


def _alpha(scores: npt.NDArray[np.float64]) -> float:
    k = int(scores.shape[1])
    total = float(np.var(scores.sum(axis=1), ddof=1))
    return k / (k - 1) * (1 - float(np.var(scores, axis=0, ddof=1).sum()) / total)
