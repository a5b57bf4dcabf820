"""The exact Wilcoxon signed-rank test, ties included."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import stats

from analysis.statistics.result import EffectResult, EffectSize, Outcome, Refusal


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
        effects=(EffectSize("r_rb", (2 * positive - total) / total),),
        rows=2 * differences.size,
        participants=participants,
        note=f"{differences.size - kept.size} differences of zero dropped."
        if kept.size < differences.size
        else "",
    )
