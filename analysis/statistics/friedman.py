"""Friedman's test: do three or more conditions differ in the participants' ranks?

Source: Friedman (1937), Journal of the American Statistical Association 32, 675-701, with the
correction for ties; p by the chi-squared approximation. The null hypothesis is that the conditions
are exchangeable: where their scatter differs it rejects equal means too often (see
`benchmarks.statistics_error_rates`), so that it is shown beside the corrected F.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from analysis.statistics.cells import Cells
from analysis.statistics.pairs import SMALLEST_N, not_finite
from analysis.statistics.result import EffectResult, EffectSize, Outcome, Refusal


def friedman(cells: Cells, name: str = "Friedman's test of ranks") -> Outcome:
    """Test three or more conditions by ranks within participants; W is Kendall's concordance.

    Args:
        cells: one value for each participant and condition.
        name: what the tables call the test.
    """
    n, k = cells.means.shape
    if k < 3:
        reason = f"The test compares three or more conditions; these data hold {k}."
        return Refusal(name, reason, cells.excluded)
    if n < SMALLEST_N:
        reason = f"The test needs at least {SMALLEST_N} participants; {n} have every condition."
        return Refusal(name, reason, cells.excluded)
    refusal = not_finite(cells, name)
    if refusal is not None:
        return refusal
    ranks = stats.rankdata(cells.means, axis=1)
    spread = float(np.sum((ranks - (k + 1) / 2) ** 2))
    if spread == 0:
        reason = "Every participant has the same value under all conditions."
        return Refusal(name, reason, cells.excluded)
    between = n * n * float(np.sum((ranks.mean(axis=0) - (k + 1) / 2) ** 2))
    chi2 = (k - 1) * between / spread
    return EffectResult(
        name=name,
        formula="ranks within participants ~ condition",
        role="sensitivity",
        statistic_name="χ²",
        statistic=chi2,
        df1=k - 1,
        df2=None,
        p=float(stats.chi2.sf(chi2, k - 1)),
        estimate=None,
        interval=None,
        effects=(EffectSize("Kendall's W", chi2 / (n * (k - 1))),),
        rows=n * k,
        participants=cells.participants,
        excluded=cells.excluded,
        method="chi-squared approximation",
    )
