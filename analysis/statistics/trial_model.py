"""The trial-level model of a measure: condition, trial and period, participants as random."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import pandas as pd

from analysis.statistics.mixed.model import MixedModel, mixed_model
from analysis.statistics.result import Refusal, Role


def trial_model(
    frame: pd.DataFrame,
    levels: Sequence[str],
    value: str = "team_reward",
    *,
    covariates: Sequence[str] = (),
    crossed: Mapping[str, Sequence[str]] | None = None,
    name: str = "Mixed model of trials",
    role: Role = "sensitivity",
) -> MixedModel | Refusal:
    """Fit value ~ condition + trial + period + (1 | participant) + (1 | participant:condition).

    The estimate of condition is its difference at the mean trial. A trial or period that does
    not vary is left out, and so is the effect of participant by condition where each cell has
    one row; the note says so. It is the primary test where trials are missing.

    Args:
        frame: columns "participant", "condition", "trial" (number within its block), the value,
            and, if known, "period" (place of the block in the session, from 1).
        levels: conditions, the reference first.
        value: the column explained.
        covariates: further columns of numbers.
        crossed: levels of factors whose cells the conditions are: they and their interactions
            take the place of condition; each has its column.
        name: what the tables call it.
        role: primary, sensitivity or comparison.
    """
    rows = frame[frame["condition"].isin(list(levels))]
    if rows.empty:
        return Refusal(name, "There are no trial rows under the conditions compared.")
    factors = {"condition": tuple(levels)}
    terms, notes = ["condition"], []
    if crossed:
        factors = {name: tuple(own) for name, own in crossed.items()}
        terms = [" * ".join(crossed)]
    trial = rows["trial"].astype("float64")
    if trial.max() > trial.min():
        rows = rows.assign(trial=trial - trial.mean())
        terms.append("trial")
    periods = sorted(set(rows["period"])) if "period" in rows.columns else []
    if len(periods) > 1:
        factors["period"] = tuple(str(period) for period in periods)
        terms.append("period")
        pairs = rows[["condition", "period"]].drop_duplicates()
        if len(pairs) == len(set(rows["condition"])):
            # Everybody had the same order: period and condition are one and the same.
            terms.remove("period")
            del factors["period"]
            notes.append("All had the same order, so that period is not told from condition.")
    random = ["(1 | participant)"]
    counts = rows.groupby(["participant", "condition"], observed=True).size()
    if crossed:
        # Each effect then has the error term that it has on participants' means.
        random += [
            f"(1 | {':'.join(('participant', *chosen))})"
            for size in range(1, len(crossed))
            for chosen in itertools.combinations(crossed, size)
        ]
    if counts.max() > 1:
        random.append("(1 | participant:condition)")
    else:
        notes.append("One row a cell: participant by condition is the residual.")
    formula = f"{value} ~ {' + '.join([*terms, *covariates, *random])}"
    return mixed_model(rows, formula, factors, name=name, role=role, note=" ".join(notes))
