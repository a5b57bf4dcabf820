"""Equivalence of two conditions: two one-sided tests against a bound stated beforehand."""

from __future__ import annotations

import math

import numpy as np
from scipy import stats

from analysis.statistics.cells import Cells
from analysis.statistics.pairs import differences
from analysis.statistics.result import EffectResult, Interval, Outcome, Refusal


def equivalence(
    cells: Cells, bound: float | None, name: str = "Equivalence (two one-sided tests)"
) -> Outcome:
    """Test whether the difference lies within plus or minus the bound.

    The interval is the 90 % one: it lies within the bounds exactly where p < 5 %.
    Source: Schuirmann (1987), Journal of Pharmacokinetics and Biopharmaceutics 15, 657-680.

    Args:
        cells: participant means under two conditions.
        bound: the smallest difference that would matter, in the measure's unit, as the protocol
            states it; None refuses, as a bound chosen after the data proves nothing.
        name: what the tables call the test.
    """
    if bound is None:
        reason = (
            "The protocol states no bound, and a bound chosen after seeing the data would prove "
            "nothing. A large p of the primary test does not show that conditions are alike."
        )
        return Refusal(name, reason, cells.excluded)
    if not (math.isfinite(bound) and bound > 0):
        reason = f"The bound must be a positive number; {bound:g} was given."
        return Refusal(name, reason, cells.excluded)
    found = differences(cells, name)
    if isinstance(found, Refusal):
        return found
    ordered = np.sort(found)
    n, mean = cells.n, float(np.mean(ordered))
    error = float(np.std(ordered, ddof=1)) / math.sqrt(n)
    above, below = (mean + bound) / error, (mean - bound) / error
    p_low, p_high = float(stats.t.sf(above, n - 1)), float(stats.t.cdf(below, n - 1))
    nearer = above if p_low > p_high else below
    reach = float(stats.t.ppf(0.95, n - 1)) * error
    return EffectResult(
        name=name,
        formula=f"|mean difference| < {bound:g}",
        role="sensitivity",
        statistic_name="t",
        statistic=nearer,
        df1=None,
        df2=n - 1,
        p=max(p_low, p_high),
        estimate=mean,
        interval=Interval(mean - reach, mean + reach, 0.90),
        effects=(),
        rows=2 * n,
        participants=cells.participants,
        excluded=cells.excluded,
        note=f"p against the lower bound {p_low:.3g}, against the upper {p_high:.3g}.",
        method="two one-sided t tests",
        standard_error=error,
    )
