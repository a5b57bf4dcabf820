"""Standardised effects with exact intervals, by inverting noncentral distributions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import optimize, stats

from analysis.statistics.result import EffectSize, Interval


def hedges_gz(dz: EffectSize, n: int) -> EffectSize:
    """Return g_z: d_z and its interval times Hedges' exact correction for n - 1 df.

    Source: Hedges (1981), Journal of Educational Statistics 6, 107-128, equation 6e.
    """
    df = n - 1
    log_factor = math.lgamma(df / 2) - math.lgamma((df - 1) / 2) - 0.5 * math.log(df / 2)
    factor = math.exp(log_factor)
    inner = dz.interval
    interval = Interval(inner.low * factor, inner.high * factor, inner.level) if inner else None
    return EffectSize("g_z", dz.value * factor, interval)


def cohens_dz(t: float, n: int, level: float = 0.95) -> EffectSize:
    """Return d_z = t / sqrt(n) of a paired test with its exact noncentral-t interval.

    Args:
        t: the paired t statistic.
        n: number of pairs.
        level: level of confidence.
    """
    tail = (1 - level) / 2
    df = n - 1

    def noncentrality(probability: float) -> float:
        def gap(ncp: float) -> float:
            return float(stats.nct.cdf(t, df, ncp)) - probability

        return _root_of_falling(gap, start=t, step=max(1.0, abs(t)))

    low, high = noncentrality(1 - tail), noncentrality(tail)
    root_n = math.sqrt(n)
    return EffectSize("d_z", t / root_n, Interval(low / root_n, high / root_n, level))


def partial_eta_squared(f: float, df1: float, df2: float, level: float = 0.90) -> EffectSize:
    """Return partial eta squared with its noncentral-F interval, cut off at 0.

    The 90 % interval is usual, as its lower end agrees with the one-sided F test at 5 %.
    """
    tail = (1 - level) / 2

    def bound(probability: float) -> float:
        if float(stats.f.cdf(f, df1, df2)) <= probability:
            return 0.0

        def gap(ncp: float) -> float:
            return float(stats.ncf.cdf(f, df1, df2, ncp)) - probability

        ncp = _root_of_falling(gap, start=f * df1, step=max(1.0, f * df1), lowest=1e-12)
        return ncp / (ncp + df2)

    value = f * df1 / (f * df1 + df2)
    return EffectSize("partial eta squared", value, Interval(bound(1 - tail), bound(tail), level))


def generalised_eta_squared(values: npt.NDArray[np.float64]) -> EffectSize:
    """Return generalised eta squared of a one-factor within-subjects design.

    Args:
        values: one row a participant, one column a condition, shape (n, k). The
            denominator keeps the variance between participants (Olejnik & Algina 2003).
    """
    n, k = values.shape
    centred = values - values.mean()
    effect = n * float(np.sum(centred.mean(axis=0) ** 2))
    subjects = k * float(np.sum(centred.mean(axis=1) ** 2))
    error = float(np.sum(centred**2)) - effect - subjects
    return EffectSize("generalised eta squared", effect / (effect + subjects + error))


def _root_of_falling(
    gap: Callable[[float], float], start: float, step: float, lowest: float = -math.inf
) -> float:
    """Find where a falling function crosses zero, widening the bracket until it holds it."""
    low = high = max(start, lowest)
    while gap(low) < 0 and low > lowest:
        low = max(low - step, lowest)
    while gap(high) > 0:
        high += step
    return float(optimize.brentq(gap, low, high, xtol=1e-12, rtol=1e-12))
