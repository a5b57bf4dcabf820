"""Means over trials, and differences paired by trial: each trial is one world for all scorers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy import stats

from analysis.statistics.holm import holm
from analysis.statistics.result import ALPHA, Interval


@dataclasses.dataclass(frozen=True, slots=True)
class Mean:
    """A mean over trials with its t interval.

    Attributes:
        value: the mean; nan without data.
        interval: 95 %; None with fewer than two trials.
        n: trials.
    """

    value: float
    interval: Interval | None
    n: int


@dataclasses.dataclass(frozen=True, slots=True)
class Contrast:
    """A paired difference of two scorers.

    Attributes:
        hypothesis: "H1", "H2" or another heading.
        measure: what differs, in words.
        unit: "points" or "share".
        first: the scorer named first.
        second: the other.
        mean: first minus second, with interval.
        t: the paired t statistic; None where all differences are equal.
        p: two-sided, unadjusted.
        p_adjusted: Holm's, over the contrasts of the hypothesis.
        better: part of the trials in which the first is ahead; ties count half.
    """

    hypothesis: str
    measure: str
    unit: str
    first: str
    second: str
    mean: Mean
    t: float | None
    p: float
    p_adjusted: float
    better: float

    @property
    def verdict(self) -> str:
        """Return "higher", "lower" or "undecided", at Holm's p."""
        if self.p_adjusted >= ALPHA or self.mean.value == 0:
            return "undecided"
        return "higher" if self.mean.value > 0 else "lower"


def mean_of(values: npt.NDArray[np.float64] | pd.Series[float]) -> Mean:
    """Return the mean with its 95 % t interval; what is missing is left out."""
    data = np.asarray(values, np.float64)
    data = data[np.isfinite(data)]
    if not len(data):
        return Mean(math.nan, None, 0)
    centre = float(data.mean())
    if len(data) < 2:
        return Mean(centre, None, len(data))
    error = float(data.std(ddof=1)) / math.sqrt(len(data))
    reach = float(stats.t.ppf(0.975, len(data) - 1)) * error
    return Mean(centre, Interval(centre - reach, centre + reach), len(data))


def by_scorer(frame: pd.DataFrame, measure: str) -> pd.DataFrame:
    """Return one row a trial and one column a scorer of a measure."""
    return frame.set_index(["trial", "scorer"])[measure].astype(float).unstack()  # noqa: PD010


def paired(
    hypothesis: str,
    measure: str,
    unit: str,
    wide: pd.DataFrame,
    first: str,
    second: str,
) -> Contrast | None:
    """Compare two columns trial by trial; None unless two trials have both."""
    if first not in wide or second not in wide:
        return None
    gaps = (wide[first] - wide[second]).dropna().to_numpy(np.float64)
    if len(gaps) < 2:
        return None
    spread = float(gaps.std(ddof=1))
    centre = mean_of(gaps)
    if spread <= 1e-12 * max(1.0, float(np.abs(gaps).max())):
        t, p = None, 1.0 if centre.value == 0 else 0.0
    else:
        t = centre.value / (spread / math.sqrt(len(gaps)))
        p = float(2 * stats.t.sf(abs(t), len(gaps) - 1))
    better = float(((gaps > 0) + 0.5 * (gaps == 0)).mean())
    return Contrast(hypothesis, measure, unit, first, second, centre, t, p, p, better)


def adjusted(contrasts: Sequence[Contrast | None]) -> list[Contrast]:
    """Return those that were computed, with Holm's p over all of them."""
    found = [each for each in contrasts if each is not None]
    return [
        dataclasses.replace(each, p_adjusted=p)
        for each, p in zip(found, holm([each.p for each in found]), strict=True)
    ]
