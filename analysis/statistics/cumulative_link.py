"""Ordinal answers by a cumulative-link (proportional odds) mixed model."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy import stats

from analysis.statistics.cumulative_likelihood import NODES, Answers, Maximum, maximise
from analysis.statistics.mixed.design import (
    Column,
    Design,
    NotEstimableError,
    build_design,
    sum_to_zero,
)
from analysis.statistics.mixed.formula import Formula, FormulaError, RandomTerm, parse_formula
from analysis.statistics.mixed.rows import left_out, participant_column, usable_rows
from analysis.statistics.result import (
    EffectResult,
    EffectSize,
    Interval,
    Refusal,
)

Floats = npt.NDArray[np.float64]
SMALLEST_N = 3
RUNAWAY = 15.0  # log odds; an odds ratio of three million is no estimate


@dataclasses.dataclass(frozen=True, slots=True)
class LogOdds:
    """A coefficient in treatment coding: log odds of a higher answer, with Wald's z.

    Attributes:
        name: R's name of it: "conditionassisted", "age", ...
        estimate, standard_error, z, p, interval: of the log odds ratio; 95 %.
    """

    name: str
    estimate: float
    standard_error: float
    z: float
    p: float
    interval: Interval


@dataclasses.dataclass(frozen=True, slots=True)
class CumulativeLink:
    """A fitted model.

    Attributes:
        tests: the likelihood-ratio test of each term, in the order of the terms; of a factor of two
            levels in a model of its own the estimate is the log odds ratio.
        coefficients: in treatment coding.
        thresholds: (label, value), as "3|4".
        participant_sd: standard deviation of the random intercepts, log odds.
        log_likelihood: at the maximum.
    """

    tests: tuple[EffectResult, ...]
    coefficients: tuple[LogOdds, ...]
    thresholds: tuple[tuple[str, float], ...]
    participant_sd: float
    log_likelihood: float

    @property
    def test(self) -> EffectResult:
        """The test of the first term."""
        return self.tests[0]


def cumulative_link(
    frame: pd.DataFrame,
    levels: Sequence[str],
    value: str = "answer",
    name: str = "Cumulative-link mixed model",
) -> CumulativeLink | Refusal:
    """Fit answer ~ condition + (1 | participant); see `cumulative_link_model`.

    Participants who lack a condition are used: the model needs no complete pairs.

    Args:
        frame: columns "participant", "condition" and the value: whole numbers.
        levels: conditions, the reference first.
        value: the column of answers; only answers that occur are categories.
        name: what the tables call the test.
    """
    formula = f"{value} ~ condition + (1 | participant)"
    found = cumulative_link_model(frame, formula, {"condition": tuple(levels)}, name=name)
    if isinstance(found, Refusal):
        return found
    return dataclasses.replace(found, tests=(dataclasses.replace(found.test, name=name),))


def cumulative_link_model(
    frame: pd.DataFrame,
    formula: str,
    levels: Mapping[str, Sequence[object]],
    *,
    name: str = "Cumulative-link mixed model",
    nodes: int = NODES,
) -> CumulativeLink | Refusal:
    """Fit answers on an ordered scale, logit link, thresholds free, as R's ordinal::clmm.

    Each term is tested by the likelihood ratio against the model without it, in sum-to-zero coding
    (type III, as afex::mixed(method = "LRT")): a main effect is then that at the mean of the other
    factors.

    Args:
        frame: one row an answer, whole numbers. Rows without a value are left out and counted.
        formula: as "answer ~ allocation * robots + age + (1 | participant)".
        levels: levels of each factor, the reference first; other columns are numbers.
        name: what the tables call the tests, before the term.
        nodes: of the adaptive quadrature, as clmm's nAGQ; 1 is Laplace's approximation, clmm's
            default.

    Returns:
        The model, or a refusal: an unreadable formula, fewer than three participants, a level
        without answers, one answer only, columns that are missing or hold no numbers, or answers so
        separated that the estimate has no finite maximum.
    """
    words = f"{formula}, cumulative logit"
    try:
        parsed = parse_formula(formula)
        wanted = RandomTerm(parsed.random[0].group, ()) if parsed.random else None
        if parsed.random != (wanted,) or not parsed.terms:
            raise NotEstimableError(
                "The model has one random term, as (1 | participant), and a term to test."
            )
        if nodes < 1:
            raise NotEstimableError(f"The quadrature needs one node or more; given: {nodes}.")
        levels = {factor: known for factor, known in levels.items() if factor in parsed.names}
        who = participant_column(frame, parsed)
        rows, dropped = usable_rows(frame, parsed, levels, who)
        _refuse_answers(rows, parsed, levels, who)
        design = build_design(rows, parsed, levels)
    except (FormulaError, NotEstimableError) as problem:
        return Refusal(name, str(problem), formula=words)
    categories, codes = np.unique(design.y, return_inverse=True)
    members = design.z[:, design.blocks[0].columns]
    x, middle, scale = _standardised(design.x[:, 1:])
    given = Answers(codes.astype(np.int64), len(categories), x, members, nodes)
    found = maximise(given)
    coded, _, _ = _standardised(sum_to_zero(design)[:, 1:])
    without = {
        term: maximise(dataclasses.replace(given, x=coded[:, _others(design, term)]))
        for term in design.terms
    }
    cuts = len(categories) - 1
    beta = found.parameters[cuts:-1]
    errors = np.sqrt(np.maximum(np.diag(found.covariance)[cuts:-1], 0))
    converged = all(one.converged for one in (found, *without.values()))
    steep = np.abs(beta) * np.ptp(x, axis=0) > RUNAWAY
    runaway = np.abs(found.parameters).max() > 4 * RUNAWAY or bool(np.any(steep))
    if not converged or not np.all(errors > 0) or runaway:
        reason = (
            "The answers under the conditions are so separated, or so alike within participants, "
            "that the model's likelihood has no finite maximum. The exact Wilcoxon test stands."
        )
        return Refusal(name, reason, formula=words)
    coefficients = tuple(
        _log_odds(column, float(b), float(e))
        for column, b, e in zip(design.columns[1:], beta / scale, errors / scale, strict=True)
    )
    people = tuple(sorted(set(rows[who])))
    base = _blank(name, words, len(codes), people)
    base = dataclasses.replace(base, excluded=left_out(frame, rows, who), rows_excluded=dropped)
    cut = found.parameters[:cuts] + float(beta @ (middle / scale))
    labels = [f"{categories[j]:g}|{categories[j + 1]:g}" for j in range(cuts)]
    return CumulativeLink(
        tests=tuple(_test(base, design, t, found, without[t], coefficients) for t in design.terms),
        coefficients=coefficients,
        thresholds=tuple(zip(labels, (float(a) for a in cut), strict=True)),
        participant_sd=float(found.parameters[-1]),
        log_likelihood=found.log_likelihood,
    )


def _refuse_answers(
    rows: pd.DataFrame, formula: Formula, levels: Mapping[str, Sequence[object]], who: str
) -> None:
    people, answers = set(rows[who]), rows[formula.response].to_numpy(dtype=np.float64)
    for factor, known in levels.items():
        empty = [str(level) for level in known if str(level) not in set(rows[factor])]
        if empty:
            raise NotEstimableError(f"There are no answers under {' or '.join(empty)}.")
    if len(people) < SMALLEST_N:
        raise NotEstimableError(
            f"The model needs at least {SMALLEST_N} participants; {len(people)} answered."
        )
    if np.any(answers != np.rint(answers)):
        raise NotEstimableError(
            f"The column {formula.response} holds numbers that are not whole; the model is for "
            "answers on a scale of whole numbers."
        )
    if len(np.unique(answers)) < 2:
        raise NotEstimableError("Every answer is the same, so that there is nothing to explain.")


def _others(design: Design, term: tuple[str, ...]) -> list[int]:
    """Return the places of all columns but a term's, without the intercept."""
    return [place for place, c in enumerate(design.columns[1:]) if c.term != term]


def _standardised(x: Floats) -> tuple[Floats, Floats, Floats]:
    """Centre and scale columns of numbers, so that steps of derivatives suit any unit.

    Returns:
        x, and what was subtracted and divided by: 0 and 1 for columns of a factor.
    """
    coded = np.all(np.isin(x, (-1.0, 0.0, 1.0)), axis=0)
    middle = np.where(coded, 0.0, x.mean(axis=0))
    scale = np.where(coded, 1.0, x.std(axis=0))
    return (x - middle) / scale, middle, scale


def _blank(name: str, formula: str, rows: int, people: tuple[str, ...]) -> EffectResult:
    return EffectResult(
        name=name,
        formula=formula,
        role="sensitivity",
        statistic_name="χ²",
        statistic=math.nan,
        df1=None,
        df2=None,
        p=math.nan,
        estimate=None,
        interval=None,
        effects=(),
        rows=rows,
        participants=people,
        unit="log odds",
        method="likelihood ratio",
    )


def _test(
    base: EffectResult,
    design: Design,
    term: tuple[str, ...],
    full: Maximum,
    without: Maximum,
    coefficients: Sequence[LogOdds],
) -> EffectResult:
    own = [
        c for c, column in zip(coefficients, design.columns[1:], strict=True) if column.term == term
    ]
    ratio = max(0.0, 2 * (full.log_likelihood - without.log_likelihood))
    result = dataclasses.replace(
        base,
        name=f"{base.name}: {':'.join(term)}",
        statistic=ratio,
        df1=len(own),
        p=float(stats.chi2.sf(ratio, len(own))),
    )
    contained = any(set(term) < set(other) for other in design.terms)
    if len(own) != 1 or contained:
        return result
    one = own[0]
    bounds = Interval(math.exp(one.interval.low), math.exp(one.interval.high))
    return dataclasses.replace(
        result,
        estimate=one.estimate,
        interval=one.interval,
        standard_error=one.standard_error,
        effects=(EffectSize("odds ratio", math.exp(one.estimate), bounds),),
        note=f"Wald z = {one.z:.2f}, p = {one.p:.3g}.",
    )


def _log_odds(column: Column, estimate: float, error: float) -> LogOdds:
    z = estimate / error
    reach = float(stats.norm.ppf(0.975)) * error
    bounds = Interval(estimate - reach, estimate + reach)
    return LogOdds(column.name, estimate, error, z, 2 * float(stats.norm.sf(abs(z))), bounds)
