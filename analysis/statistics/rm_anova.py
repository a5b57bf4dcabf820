"""The primary test: repeated-measures ANOVA on participant-by-condition means.

With two conditions it is the paired t test, F(1, n - 1) = t squared, and is computed as
such; with more it is pingouin's, with Greenhouse and Geisser's correction.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
import pandas as pd
from scipy import stats

from analysis.statistics.cells import Cells
from analysis.statistics.effect_sizes import (
    cohens_dz,
    generalised_eta_squared,
    hedges_gz,
    partial_eta_squared,
)
from analysis.statistics.pairs import SMALLEST_N, not_finite
from analysis.statistics.result import EffectResult, Interval, Outcome, Refusal, Role
from analysis.statistics.within import contrasts, sphericity


def rm_anova(
    cells: Cells,
    name: str = "Participant means, paired (RM-ANOVA)",
    role: Role = "primary",
    rows: int | None = None,
) -> Outcome:
    """Test whether condition matters, with participants as the error term.

    Args:
        cells: participant-by-condition means; the last level minus the first is the estimate
            where there are two.
        name: what the tables call the test.
        role: primary, sensitivity or comparison.
        rows: rows that entered; by default one for each cell.

    Returns:
        The result, or a refusal: fewer than three participants, fewer than two
        conditions, means that are not finite, or differences without variance.
    """
    refusal = _degenerate(cells, name)
    if refusal is not None:
        return refusal
    used = cells.means.size if rows is None else rows
    if len(cells.levels) == 2:
        return _paired(cells, name, role, used)
    return _several(cells, name, role, used)


def _degenerate(cells: Cells, name: str) -> Refusal | None:
    if len(cells.levels) < 2:
        return Refusal(name, "The data hold fewer than two conditions to compare.", cells.excluded)
    if cells.n < SMALLEST_N:
        people = "1 participant has" if cells.n == 1 else f"{cells.n} participants have"
        reason = (
            f"{people} data under every condition; a test of participants' means needs at "
            f"least {SMALLEST_N}."
        )
        return Refusal(name, reason, cells.excluded)
    refusal = not_finite(cells, name)
    if refusal is not None:
        return refusal
    differences = cells.means[:, 1:] - cells.means[:, :1]
    spread = np.ptp(differences, axis=0)
    scale = np.maximum(np.abs(cells.means).max(), 1.0)
    if np.any(spread <= 1e-12 * scale):
        reason = (
            "The difference between conditions is the same for every participant, so that it "
            "has no variance to test against."
        )
        return Refusal(name, reason, cells.excluded)
    return None


def _paired(cells: Cells, name: str, role: Role, rows: int) -> EffectResult:
    differences = np.sort(cells.means[:, 1] - cells.means[:, 0])
    n = cells.n
    estimate = float(np.mean(differences))
    error = float(np.std(differences, ddof=1)) / math.sqrt(n)
    t = estimate / error
    reach = float(stats.t.ppf(0.975, n - 1)) * error
    dz = cohens_dz(t, n)
    return EffectResult(
        name=name,
        formula="mean ~ condition, error: participant x condition",
        role=role,
        statistic_name="F",
        statistic=t * t,
        df1=1,
        df2=n - 1,
        p=2 * float(stats.t.sf(abs(t), n - 1)),
        estimate=estimate,
        interval=Interval(estimate - reach, estimate + reach),
        effects=(
            dz,
            hedges_gz(dz, n),
            partial_eta_squared(t * t, 1, n - 1),
            generalised_eta_squared(cells.means),
        ),
        rows=rows,
        participants=cells.participants,
        excluded=cells.excluded,
        standard_error=error,
    )


def _several(cells: Cells, name: str, role: Role, rows: int) -> Outcome:
    import pingouin  # noqa: PLC0415  (slow to import, and seldom needed)

    n, k = cells.means.shape
    long = pd.DataFrame(
        {
            "participant": np.repeat(np.array(cells.participants, dtype=object), k),
            "condition": np.tile(np.array(cells.levels, dtype=object), n),
            "mean": cells.means.ravel(),
        }
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # degenerate results are refused below
        table = pingouin.rm_anova(
            data=long, dv="mean", within="condition", subject="participant", correction=True
        )
    row = {str(key).replace("-", "_"): value for key, value in table.iloc[0].items()}
    f, epsilon = float(row["F"]), float(row["eps"])
    p = float(row.get("p_GG_corr", row["p_unc"]))
    if not (math.isfinite(f) and math.isfinite(p)):
        return Refusal(name, "The variance between participants is degenerate.", cells.excluded)
    df1, df2 = (k - 1) * epsilon, (k - 1) * (n - 1) * epsilon
    mauchly = sphericity(cells.means @ contrasts(k), k).mauchly
    return EffectResult(
        name=name,
        formula="mean ~ condition, error: participant x condition",
        role=role,
        statistic_name="F",
        statistic=f,
        df1=df1,
        df2=df2,
        p=p,
        estimate=None,
        interval=None,
        effects=(
            partial_eta_squared(f, k - 1, (k - 1) * (n - 1)),
            generalised_eta_squared(cells.means),
        ),
        rows=rows,
        participants=cells.participants,
        excluded=cells.excluded,
        note=f"Degrees of freedom corrected by Greenhouse and Geisser's epsilon, {epsilon:.3f}.",
        method="Greenhouse-Geisser",
        checks=(mauchly,) if mauchly else (),
    )
