"""A linear mixed model of rows: Kenward-Roger first, Satterthwaite beside it.

The maximum is lme4's, the tests are those of lmerTest and pbkrtest: type III, factors in
treatment coding. See `reml`, `kenward_roger` and `satterthwaite` for the sources.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy import stats

from analysis.statistics.effect_sizes import partial_eta_squared
from analysis.statistics.holm import holm
from analysis.statistics.mixed import kenward_roger as kr
from analysis.statistics.mixed import reml
from analysis.statistics.mixed import satterthwaite as sw
from analysis.statistics.mixed.design import Design, NotEstimableError, build_design, type_three
from analysis.statistics.mixed.formula import FormulaError, Term, parse_formula
from analysis.statistics.mixed.rows import left_out, participant_column, usable_rows
from analysis.statistics.result import EffectResult, Interval, Refusal, Role

Floats = npt.NDArray[np.float64]
SMALLEST_N = 3
SINGULAR_NOTE = (
    "A variance of the random effects, or a direction of their covariance, is estimated as zero; "
    "prefer Kenward-Roger's degrees of freedom."
)


@dataclasses.dataclass(frozen=True, slots=True)
class Coefficient:
    """One fixed coefficient in treatment coding, with a t test.

    Attributes:
        name: "(Intercept)", "conditionassisted", "trial", ...
        estimate, standard_error, df, t, p, interval: of the coefficient; 95 %.
    """

    name: str
    estimate: float
    standard_error: float
    df: float
    t: float
    p: float
    interval: Interval


@dataclasses.dataclass(frozen=True, slots=True)
class VarianceComponent:
    """A variance (second is None) or a covariance of random effects, in the measure's unit squared.

    Attributes:
        group: "participant", "participant:condition", or "Residual".
        first: the effect; empty for the residual.
        second: the other effect of a covariance.
        value: the component.
        correlation: of the two effects; None for a variance, or where one does not vary.
    """

    group: str
    first: str
    second: str | None
    value: float
    correlation: float | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class MixedModel:
    """A fitted model.

    Attributes:
        formula: as given.
        tests: a Kenward-Roger F test of each term, in the order of the terms.
        satterthwaite: the same terms with Satterthwaite's degrees of freedom.
        pairs: pairwise differences of the levels of each factor that has more than two, by factor
            (Kenward-Roger, Holm-adjusted within the factor); averaged over the other factors.
        coefficients: in treatment coding, with Kenward-Roger's standard errors and df.
        coefficients_satterthwaite: the same with Satterthwaite's.
        components: variances and covariances; the residual is the last.
        criterion: -2 log restricted likelihood.
        singular: whether the fit is on the boundary.
    """

    formula: str
    tests: tuple[EffectResult, ...]
    satterthwaite: tuple[EffectResult, ...]
    pairs: Mapping[str, tuple[EffectResult, ...]]
    coefficients: tuple[Coefficient, ...]
    coefficients_satterthwaite: tuple[Coefficient, ...]
    components: tuple[VarianceComponent, ...]
    criterion: float
    singular: bool

    @property
    def contrasts(self) -> tuple[EffectResult, ...]:
        """Pairs of the levels of the first factor among the terms; none where it has two."""
        named = [r.name.split(": ", 1)[-1] for r in self.tests]
        return next((self.pairs[term] for term in named if term in self.pairs), ())

    def test(self, term: str) -> EffectResult:
        """Return the Kenward-Roger test of a term such as "condition" or "condition:trial".

        Raises:
            KeyError: no such term.
        """
        for result in self.tests:
            if result.name.endswith(f": {term}"):
                return result
        raise KeyError(term)


def mixed_model(
    frame: pd.DataFrame,
    formula: str,
    levels: Mapping[str, Sequence[object]],
    *,
    name: str = "Mixed model",
    role: Role = "sensitivity",
    participant: str = "",
    note: str = "",
) -> MixedModel | Refusal:
    """Fit a model and test each of its terms.

    Args:
        frame: one row an observation. Rows without a value (NaN) in a column of the model are
            left out and counted.
        formula: as in lme4: "reward ~ condition * trial + (1 + condition | participant)".
        levels: levels of each factor, the reference first; columns that are not named here
            are numbers, but for grouping columns.
        name: what the tables call the tests, before the term.
        role: of the Kenward-Roger tests; Satterthwaite's are always sensitivity.
        participant: the column that names participants; by default "participant", or, where
            there is none, what the first random term groups by.
        note: a sentence to carry along.

    Returns:
        The model, or a refusal: an unreadable formula, fewer than three participants, an empty
        cell, coefficients or variances that the rows do not determine, values that are not
        finite, no scatter.
    """
    try:
        parsed = parse_formula(formula)
        if not parsed.random:
            raise NotEstimableError("The formula has no random term such as (1 | participant).")
        levels = {factor: known for factor, known in levels.items() if factor in parsed.names}
        who = participant or participant_column(frame, parsed)
        rows, dropped = usable_rows(frame, parsed, levels, who)
        people = tuple(sorted(set(rows[who])))
        gone = left_out(frame, rows, who)
        if len(people) < SMALLEST_N:
            raise NotEstimableError(
                f"A mixed model needs at least {SMALLEST_N} participants; the rows hold "
                f"{len(people)}."
            )
        design = build_design(rows, parsed, levels)
    except (FormulaError, NotEstimableError) as problem:
        return Refusal(name, str(problem), formula=formula)
    given = reml.moments(design)
    if given is None:
        return Refusal(name, "The rows do not scatter about the model.", formula=formula)
    try:
        fit = reml.fit(given, design.blocks)
        small, large = kr.kenward_roger(fit), sw.satterthwaite(fit)
    except np.linalg.LinAlgError:
        reason = "The likelihood of the model has no maximum that can be found for these rows."
        return Refusal(name, reason, formula=formula)
    if not fit.point.rss > 1e-12 * given.yy:
        reason = "The random effects explain the rows without any scatter left to test against."
        return Refusal(name, reason, formula=formula)
    base = EffectResult(
        name=name,
        formula=parsed.text,
        role=role,
        statistic_name="F",
        statistic=math.nan,
        df1=None,
        df2=None,
        p=math.nan,
        estimate=None,
        interval=None,
        effects=(),
        rows=len(design.y),
        participants=people,
        excluded=gone,
        note=" ".join(part for part in (note, SINGULAR_NOTE if fit.singular else "") if part),
        rows_excluded=dropped,
    )
    try:
        tests = tuple(_term_test(base, design, term, small) for term in design.terms)
        others = tuple(_term_test(base, design, term, large) for term in design.terms)
    except NotEstimableError as problem:
        return Refusal(name, str(problem), formula=formula)
    return MixedModel(
        formula=parsed.text,
        tests=tests,
        satterthwaite=others,
        pairs=_pairs(base, design, small),
        coefficients=_coefficients(design, small),
        coefficients_satterthwaite=_coefficients(design, large),
        components=_components(fit),
        criterion=fit.criterion,
        singular=fit.singular,
    )


def _variance(parts: kr.KenwardRoger | sw.Satterthwaite) -> Floats:
    return parts.adjusted if isinstance(parts, kr.KenwardRoger) else parts.phi


def _test(parts: kr.KenwardRoger | sw.Satterthwaite, contrasts: Floats) -> kr.FTest:
    if isinstance(parts, kr.KenwardRoger):
        return kr.f_test(parts, contrasts)
    return sw.f_test(parts, contrasts)


def _term_test(
    base: EffectResult, design: Design, term: Term, parts: kr.KenwardRoger | sw.Satterthwaite
) -> EffectResult:
    contrasts = type_three(design, term)
    tested = _test(parts, contrasts)
    if not (math.isfinite(tested.f) and tested.df2 > 0):
        raise NotEstimableError(
            f"The rows are too few to tell the error of {':'.join(term)}: no degrees of freedom "
            "are left for it."
        )
    first = isinstance(parts, kr.KenwardRoger)
    result = dataclasses.replace(
        base,
        name=f"{base.name}: {':'.join(term)}",
        role=base.role if first else "sensitivity",
        statistic=tested.f,
        df1=tested.df1,
        df2=tested.df2,
        p=float(stats.f.sf(tested.f, tested.df1, tested.df2)),
        method="Kenward-Roger" if first else "Satterthwaite",
        effects=(partial_eta_squared(tested.f, tested.df1, tested.df2),),
    )
    return _estimated(result, contrasts[0], parts) if len(contrasts) == 1 else result


def _estimated(
    result: EffectResult, contrast: Floats, parts: kr.KenwardRoger | sw.Satterthwaite
) -> EffectResult:
    assert result.df2 is not None  # noqa: S101  (set by the caller)
    estimate = float(contrast @ parts.beta)
    error = math.sqrt(float(contrast @ _variance(parts) @ contrast))
    reach = float(stats.t.ppf(0.975, result.df2)) * error
    bounds = Interval(estimate - reach, estimate + reach)
    return dataclasses.replace(result, estimate=estimate, standard_error=error, interval=bounds)


def _pairs(
    base: EffectResult, design: Design, parts: kr.KenwardRoger
) -> dict[str, tuple[EffectResult, ...]]:
    """Compare the levels of each factor among the terms pair by pair."""
    named = [term[0] for term in design.terms if len(term) == 1 and term[0] in design.factors]
    return {
        factor: _pairwise(base, design, parts, factor)
        for factor in named
        if len(design.factors[factor]) > 2
    }


def _pairwise(
    base: EffectResult, design: Design, parts: kr.KenwardRoger, factor: str
) -> tuple[EffectResult, ...]:
    levels = design.factors[factor]
    width = len(design.columns)
    rows = [np.zeros(width)]
    # A level against the reference; the same with several terms or one.
    averaged = dataclasses.replace(design, terms=(*design.terms, ()))
    rows += list(type_three(averaged, (factor,)))
    found = []
    for (i, a), (j, b) in itertools.combinations(enumerate(levels), 2):
        contrast = rows[j] - rows[i]
        tested = kr.f_test(parts, contrast[None, :])
        result = dataclasses.replace(
            base,
            name=f"{base.name}: {b} − {a}",
            statistic_name="t",
            statistic=math.copysign(math.sqrt(tested.f), float(contrast @ parts.beta)),
            df2=tested.df2,
            p=float(stats.f.sf(tested.f, 1, tested.df2)),
            method="Kenward-Roger",
        )
        found.append(_estimated(result, contrast, parts))
    adjusted = holm([result.p for result in found])
    return tuple(
        dataclasses.replace(result, p_adjusted=p) for result, p in zip(found, adjusted, strict=True)
    )


def _coefficients(
    design: Design, parts: kr.KenwardRoger | sw.Satterthwaite
) -> tuple[Coefficient, ...]:
    found = []
    for place, column in enumerate(design.columns):
        contrast = np.zeros(len(design.columns))
        contrast[place] = 1.0
        df = _test(parts, contrast[None, :]).df2
        estimate = float(parts.beta[place])
        error = math.sqrt(float(_variance(parts)[place, place]))
        t = estimate / error
        reach = float(stats.t.ppf(0.975, df)) * error
        bounds = Interval(estimate - reach, estimate + reach)
        p = 2 * float(stats.t.sf(abs(t), df))
        found.append(Coefficient(column.name, estimate, error, df, t, p, bounds))
    return tuple(found)


def _components(fit: reml.Fit) -> tuple[VarianceComponent, ...]:
    found = []
    for block, matrix in zip(fit.blocks, fit.covariances(), strict=True):
        for i, first in enumerate(block.effects):
            found.append(VarianceComponent(block.group, first, None, float(matrix[i, i])))
        for i, j in itertools.combinations(range(block.size), 2):
            scale = math.sqrt(matrix[i, i] * matrix[j, j])
            correlation = float(matrix[i, j]) / scale if scale > 0 else None
            names = block.effects[i], block.effects[j]
            found.append(VarianceComponent(block.group, *names, float(matrix[i, j]), correlation))
    return (*found, VarianceComponent("Residual", "", None, fit.sigma**2))
