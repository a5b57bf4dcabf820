"""Ordinal answers by a cumulative-link (proportional odds) mixed model."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy import stats

from analysis.statistics.cumulative_likelihood import Answers, maximise
from analysis.statistics.result import (
    EffectResult,
    EffectSize,
    Excluded,
    ExcludedRows,
    Interval,
    Refusal,
)

SMALLEST_N = 3
RUNAWAY = 15.0  # log odds; an odds ratio of three million is no estimate


@dataclasses.dataclass(frozen=True, slots=True)
class LogOdds:
    """A condition against the reference: log odds of a higher answer, with Wald's z.

    Attributes:
        level: the condition.
        estimate, standard_error, z, p, interval: of its log odds ratio; 95 %.
    """

    level: str
    estimate: float
    standard_error: float
    z: float
    p: float
    interval: Interval


@dataclasses.dataclass(frozen=True, slots=True)
class CumulativeLink:
    """A fitted model.

    Attributes:
        test: the likelihood-ratio test of condition; with two conditions its estimate is the
            log odds ratio.
        coefficients: one for each condition but the reference.
        thresholds: (label, value), as "3|4".
        participant_sd: standard deviation of the random intercepts, log odds.
        log_likelihood: at the maximum.
    """

    test: EffectResult
    coefficients: tuple[LogOdds, ...]
    thresholds: tuple[tuple[str, float], ...]
    participant_sd: float
    log_likelihood: float


def cumulative_link(
    frame: pd.DataFrame,
    levels: Sequence[str],
    value: str = "answer",
    name: str = "Cumulative-link mixed model",
) -> CumulativeLink | Refusal:
    """Fit answer ~ condition + (1 | participant), logit link, thresholds free.

    As R's ordinal::clmm(..., nAGQ = 10). Participants who lack a condition are used: the model
    needs no complete pairs.

    Args:
        frame: columns "participant", "condition" and the value: whole numbers.
        levels: conditions, the reference first.
        value: the column of answers; only answers that occur are categories.
        name: what the tables call the test.

    Returns:
        The model, or a refusal: fewer than three participants, a condition without answers,
        one answer only, or answers so separated that the estimate has no finite maximum.
    """
    formula = f"{value} ~ condition + (1 | participant), cumulative logit"
    rows = frame[frame["condition"].astype(str).isin(list(levels))]
    missing = rows[value].isna()
    dropped = (ExcludedRows(int(missing.sum()), "no answer"),) if missing.any() else ()
    left_out = sorted(set(rows["participant"].astype(str)[missing]))
    rows = rows[~missing].assign(
        participant=lambda x: x["participant"].astype(str),
        condition=lambda x: x["condition"].astype(str),
    )
    rows = rows.sort_values(["participant", "condition", value], kind="stable")
    people = tuple(sorted(set(rows["participant"])))
    excluded = tuple(Excluded(who, "no answers") for who in left_out if who not in people)
    answers = rows[value].to_numpy(dtype=np.float64)
    empty = [level for level in levels if level not in set(rows["condition"])]
    reason = ""
    if len(levels) < 2 or empty:
        reason = f"There are no answers under {' or '.join(empty) or 'a second condition'}."
    elif len(people) < SMALLEST_N:
        reason = f"The model needs at least {SMALLEST_N} participants; {len(people)} answered."
    elif not np.isfinite(answers).all():
        reason = "An answer is not a finite number."
    elif len(np.unique(answers)) < 2:
        reason = "Every answer is the same, so that there is nothing to explain."
    if reason:
        return Refusal(name, reason, excluded, formula)
    categories, codes = np.unique(answers, return_inverse=True)
    condition = rows["condition"].to_numpy()
    x = np.column_stack([np.where(condition == level, 1.0, 0.0) for level in levels[1:]])
    members = np.equal.outer(rows["participant"].to_numpy(), np.array(people)).astype(np.float64)
    given = Answers(codes.astype(np.int64), len(categories), x, members)
    found = maximise(given)
    nothing = maximise(dataclasses.replace(given, x=np.empty((len(codes), 0))))
    cuts = len(categories) - 1
    beta = found.parameters[cuts:-1]
    errors = np.sqrt(np.maximum(np.diag(found.covariance)[cuts:-1], 0))
    lost = not (found.converged and nothing.converged and np.all(errors > 0))
    if lost or np.abs(found.parameters).max() > 4 * RUNAWAY or np.abs(beta).max() > RUNAWAY:
        reason = (
            "The answers under the conditions are so separated, or so alike within participants, "
            "that the model's likelihood has no finite maximum. The exact Wilcoxon test stands."
        )
        return Refusal(name, reason, excluded, formula)
    coefficients = tuple(
        _log_odds(level, float(b), float(e))
        for level, b, e in zip(levels[1:], beta, errors, strict=True)
    )
    ratio = max(0.0, 2 * (found.log_likelihood - nothing.log_likelihood))
    one = coefficients[0] if len(coefficients) == 1 else None
    bounds = Interval(math.exp(one.interval.low), math.exp(one.interval.high)) if one else None
    test = EffectResult(
        name=name,
        formula=formula,
        role="sensitivity",
        statistic_name="chi2",
        statistic=ratio,
        df1=len(coefficients),
        df2=None,
        p=float(stats.chi2.sf(ratio, len(coefficients))),
        estimate=one.estimate if one else None,
        interval=one.interval if one else None,
        effects=(EffectSize("odds ratio", math.exp(one.estimate), bounds),) if one else (),
        rows=len(codes),
        participants=people,
        excluded=excluded,
        note=f"Wald z = {one.z:.2f}, p = {one.p:.3g}." if one else "",
        unit="log odds",
        method="likelihood ratio",
        standard_error=one.standard_error if one else None,
        rows_excluded=dropped,
    )
    labels = [f"{categories[j]:g}|{categories[j + 1]:g}" for j in range(cuts)]
    thresholds = tuple(zip(labels, (float(a) for a in found.parameters[:cuts]), strict=True))
    sd = float(found.parameters[-1])
    return CumulativeLink(test, coefficients, thresholds, sd, found.log_likelihood)


def _log_odds(level: str, estimate: float, error: float) -> LogOdds:
    z = estimate / error
    reach = float(stats.norm.ppf(0.975)) * error
    bounds = Interval(estimate - reach, estimate + reach)
    return LogOdds(level, estimate, error, z, 2 * float(stats.norm.sf(abs(z))), bounds)
