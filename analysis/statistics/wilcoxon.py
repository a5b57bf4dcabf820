"""The exact Wilcoxon signed-rank test, ties included."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy import stats

from analysis.statistics.result import EffectResult, EffectSize, Interval, Outcome, Refusal


def signed_rank(
    differences: npt.NDArray[np.float64],
    participants: tuple[str, ...],
    name: str = "Exact Wilcoxon",
) -> Outcome:
    """Test paired differences by their signed ranks; differences of zero are dropped.

    The null distribution is exact: a dynamic programme counts, over all sign patterns, how
    often each sum of (mid)ranks occurs. Midranks are doubled, so that sums are whole numbers.

    Args:
        differences: one a participant, shape (n,).
        participants: who they are, same order.
        name: what the tables call the test.
    """
    if not np.isfinite(differences).all():
        return Refusal(name, "A difference is not a finite number.")
    kept = differences[differences != 0]
    if kept.size == 0:
        return Refusal(name, "Every difference is zero, so that there are no ranks to compare.")
    doubled = np.rint(2 * stats.rankdata(np.abs(kept))).astype(np.int64)
    total = int(doubled.sum())
    positive = int(doubled[kept > 0].sum())
    ways = np.zeros(total + 1)
    ways[0] = 1.0
    for rank in doubled:
        ways[rank:] = ways[rank:] + ways[: total + 1 - rank]
    share = ways / ways.sum()
    tail = min(float(share[: positive + 1].sum()), float(share[positive:].sum()))
    return EffectResult(
        name=name,
        formula="signed ranks of the participants' differences",
        role="sensitivity",
        statistic_name="V",
        statistic=positive / 2,
        df1=None,
        df2=None,
        p=min(1.0, 2 * tail),
        estimate=None,
        interval=None,
        effects=(rank_biserial(positive / 2, total / 2, kept.size),),
        rows=2 * differences.size,
        participants=participants,
        note=f"{differences.size - kept.size} differences of zero dropped."
        if kept.size < differences.size
        else "",
        method="exact",
    )


def rank_biserial(positive: float, total: float, n: int, level: float = 0.95) -> EffectSize:
    """Return the matched-pairs rank-biserial correlation with an approximate interval.

    The interval is normal on Fisher's z scale with the null variance of the rank sum, as R's
    effectsize gives it; there is none where all ranks have one sign.

    Args:
        positive: sum of the ranks of positive differences.
        total: sum of all ranks.
        n: differences that are not zero.
        level: of confidence.
    """
    value = (2 * positive - total) / total
    if abs(value) >= 1:
        return EffectSize("r_rb", value)
    largest = (n * n + n) / 2
    error = math.sqrt((2 * n**3 + 3 * n**2 + n) / 6) / largest
    reach = float(stats.norm.ppf((1 + level) / 2)) * error
    z = math.atanh(value)
    return EffectSize("r_rb", value, Interval(math.tanh(z - reach), math.tanh(z + reach), level))
