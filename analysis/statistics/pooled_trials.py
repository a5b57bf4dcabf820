"""The paper's trial-level form: trials of all participants pooled as if independent.

Its error term is the scatter of trials, so that it rejects a true null too often wherever
participants differ truly in the effect. It is shown for comparison, never as evidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.statistics.result import EffectResult, Interval, Outcome, Refusal

CAUTION = "Trials of one participant are treated as independent; for comparison only."


def condition_and_trial(frame: pd.DataFrame, levels: Sequence[str]) -> Outcome:
    """Fit reward ~ condition + trial on trial rows (df 189 for 192 rows).

    Args:
        frame: columns "participant", "condition", "trial" (number within its block) and
            "team_reward".
        levels: the two conditions, the reference first.
    """
    name = "Pooled rows: condition + trial"
    return _pooled(frame, levels, name, "team_reward ~ condition + trial", full=False)


def condition_trial_order(frame: pd.DataFrame, levels: Sequence[str]) -> Outcome:
    """Fit reward ~ condition x trial x order on trial rows (df 184 for 192 rows).

    Args:
        frame: as for `condition_and_trial`, with "order" (which orders were used, two values).
        levels: the two conditions, the reference first.
    """
    name = "Pooled rows: condition × trial × order"
    return _pooled(frame, levels, name, "team_reward ~ condition * trial * order", full=True)


def _pooled(
    frame: pd.DataFrame, levels: Sequence[str], name: str, formula: str, *, full: bool
) -> Outcome:
    if len(levels) != 2:
        return Refusal(
            name, "The paper's form compares two conditions; these data hold another number."
        )
    rows = frame[frame["condition"].isin(list(levels))]
    by = ["participant", "condition", "trial", "team_reward"]
    rows = rows.sort_values(by, kind="stable")
    condition = np.where(rows["condition"].to_numpy() == levels[1], 0.5, -0.5)
    trial = rows["trial"].to_numpy(dtype=np.float64)
    reward = rows["team_reward"].to_numpy(dtype=np.float64)
    # Codes of plus and minus a half and a centred covariate make the coefficient of condition
    # the difference at the mean trial, averaged over orders.
    trial = trial - trial.mean() if trial.size else trial
    columns = [np.ones_like(condition), condition, trial]
    if full:
        orders = sorted(set(rows["order"]))
        if len(orders) != 2:
            found = "1 order" if len(orders) == 1 else f"{len(orders)} orders"
            return Refusal(name, f"The form needs exactly two orders; these data hold {found}.")
        order = np.where(rows["order"].to_numpy() == orders[1], 0.5, -0.5)
        columns += [
            order,
            condition * trial,
            condition * order,
            trial * order,
            condition * trial * order,
        ]
    design = np.column_stack(columns)
    participants = tuple(sorted(set(rows["participant"])))
    return _fit(design, reward, name, formula, participants)


def _fit(
    design: npt.NDArray[np.float64],
    reward: npt.NDArray[np.float64],
    name: str,
    formula: str,
    participants: tuple[str, ...],
) -> Outcome:
    from statsmodels.regression.linear_model import OLS  # noqa: PLC0415  (slow to import)

    rows, parameters = design.shape
    if rows <= parameters or np.linalg.matrix_rank(design) < parameters:
        reason = f"The {rows} trial rows do not determine all {parameters} parameters of the model."
        return Refusal(name, reason)
    fitted: Any = OLS(reward, design).fit()
    scatter = float(fitted.ssr)
    if scatter <= 1e-20 * max(float(np.sum(reward**2)), 1.0):
        return Refusal(
            name, "The trials do not scatter about the model, so nothing to test against."
        )
    low, high = (float(bound) for bound in fitted.conf_int(0.05)[1])
    return EffectResult(
        name=name,
        formula=formula,
        role="comparison",
        statistic_name="F",
        statistic=float(fitted.tvalues[1]) ** 2,
        df1=1,
        df2=int(fitted.df_resid),
        p=float(fitted.pvalues[1]),
        estimate=float(fitted.params[1]),
        interval=Interval(low, high),
        effects=(),
        rows=rows,
        participants=participants,
        note=CAUTION,
    )
