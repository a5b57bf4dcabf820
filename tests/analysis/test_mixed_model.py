"""The mixed model against R, against dense algebra written another way, and its invariants."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.statistics.cells import cell_means
from analysis.statistics.mixed import kenward_roger as kr
from analysis.statistics.mixed import reml
from analysis.statistics.mixed import satterthwaite as sw
from analysis.statistics.mixed.design import Design, build_design, type_three
from analysis.statistics.mixed.formula import FormulaError, parse_formula
from analysis.statistics.mixed.model import MixedModel, mixed_model
from analysis.statistics.result import EffectResult, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.trial_model import trial_model

REFERENCE = Path(__file__).parent / "reference"
R: dict[str, Any] = json.loads((REFERENCE / "r_results.json").read_text())
LEVELS = {"condition": ("manual", "assisted")}
Floats = npt.NDArray[np.float64]


def study(name: str) -> pd.DataFrame:
    frame = pd.read_csv(REFERENCE / f"{name}.csv", keep_default_na=False)
    return frame.assign(tc=frame["trial"] - frame["trial"].mean())


CASES = [
    ("study192", "lmm_random_intercept", "reward ~ condition + tc + (1 | participant)"),
    ("study192", "lmm_random_slope", "reward ~ condition + tc + (condition | participant)"),
    ("study192", "lmm_nested", "reward ~ condition + tc + (1 | participant/condition)"),
    (
        "study192",
        "lmm_full",
        "reward ~ condition * tc + period + (condition + tc | participant)",
    ),
    ("study192_singular", "lmm_random_intercept", "reward ~ condition + tc + (1 | participant)"),
    (
        "study192_singular",
        "lmm_random_slope",
        "reward ~ condition + tc + (condition | participant)",
    ),
]


@pytest.mark.parametrize(("data", "key", "formula"), CASES)
def test_estimates_and_both_degrees_of_freedom_match_r(data: str, key: str, formula: str) -> None:
    """Criterion, coefficients, standard errors, F and df agree with lmerTest and pbkrtest."""
    expected = R[data][key]
    model = mixed_model(study(data), formula, LEVELS)
    assert isinstance(model, MixedModel)
    # R stops short of the maximum by up to its own tolerance.
    assert model.criterion == pytest.approx(expected["REMLcrit"], abs=1e-5)
    assert model.criterion <= expected["REMLcrit"] + 1e-8
    assert model.singular is expected["singular"]
    for ours, theirs in zip(model.coefficients, expected["coef_KR"], strict=True):
        assert ours.name == theirs["term"]
        assert ours.estimate == pytest.approx(theirs["Estimate"], rel=1e-3)
        assert ours.standard_error == pytest.approx(theirs["Std. Error"], rel=1e-3)
        assert ours.df == pytest.approx(theirs["df"], rel=1e-3)
        assert ours.p == pytest.approx(theirs["Pr(>|t|)"], rel=1e-2)
    for ours, theirs in zip(model.coefficients_satterthwaite, expected["coef_satt"], strict=True):
        assert ours.standard_error == pytest.approx(theirs["Std. Error"], rel=1e-3)
        assert ours.df == pytest.approx(theirs["df"], rel=1e-3)
    tables = ((model.tests, "kenward_roger"), (model.satterthwaite, "satterthwaite"))
    for results, table in tables:
        for result, theirs in zip(results, expected[table], strict=True):
            assert result.name.endswith(theirs["term"])
            assert result.statistic == pytest.approx(theirs["F value"], rel=1e-3, abs=2e-6)
            assert result.df1 == theirs["NumDF"]
            assert result.df2 == pytest.approx(theirs["DenDF"], rel=1e-3)
            assert result.p == pytest.approx(theirs["Pr(>F)"], rel=1e-2)
    residual = model.components[-1].value
    assert residual == pytest.approx(expected["varcor"][-1]["vcov"], rel=1e-3)


def test_condition_contrast_matches_emmeans() -> None:
    """Estimate, standard error, df and interval of condition agree with R's emmeans."""
    expected = R["study192"]["emmeans_m2_KR"][0]
    model = mixed_model(study("study192"), CASES[1][2], LEVELS)
    assert isinstance(model, MixedModel)
    result = model.test("condition")
    assert result.estimate == pytest.approx(-expected["estimate"], rel=1e-6)
    assert result.standard_error == pytest.approx(expected["SE"], rel=1e-4)
    assert result.interval is not None
    assert result.interval.low == pytest.approx(-expected["upper.CL"], rel=1e-4)
    assert result.interval.high == pytest.approx(-expected["lower.CL"], rel=1e-4)


def generated(seed: int, *, singular: bool = False, missing: int = 25) -> pd.DataFrame:
    """Make 3 x 4 rows for nine participants, three each, with a covariate, some missing."""
    generator = np.random.default_rng(seed)
    rows = []
    for person in range(9):
        base = 0.0 if singular else generator.normal(0, 3)
        slope = np.zeros(3) if singular else generator.normal(0, 1.5, 3)
        for a, b, repeat in itertools.product(range(3), range(4), range(3)):
            age = generator.normal()
            y = 10 + base + slope[a] + 0.8 * a + 0.3 * b + 0.5 * age + generator.normal(0, 2)
            rows.append((f"P{person}", f"a{a}", f"b{b}", repeat, age, y))
    frame = pd.DataFrame(rows, columns=["participant", "a", "b", "repeat", "age", "y"])
    return frame.drop(generator.choice(len(frame), missing, replace=False))


FACTORS = {"a": ("a0", "a1", "a2"), "b": ("b0", "b1", "b2", "b3")}
FORMULAS = [
    "y ~ a * b + age + (1 | participant) + (1 | participant:a)",
    "y ~ a + b + age + (1 + age | participant)",
]


def design_of(frame: pd.DataFrame, formula: str) -> Design:
    people = sorted(set(frame["participant"]))
    return build_design(frame, parse_formula(formula), {**FACTORS, "participant": people})


def dense_variance(design: Design, theta: Floats, sigma: float) -> Floats:
    """Return V by n x n matrices, straight from its definition."""
    total = np.eye(len(design.y))
    for block, factor in zip(design.blocks, reml.factors(theta, design.blocks), strict=True):
        z = design.z[:, block.columns]
        total = total + z @ np.kron(np.eye(block.groups), factor @ factor.T) @ z.T
    return sigma**2 * total


def dense_criterion(design: Design, theta: Floats, sigma: float) -> float:
    """Return -2 log restricted likelihood from the density itself."""
    v = dense_variance(design, theta, sigma)
    vi = np.linalg.inv(v)
    xvx = design.x.T @ vi @ design.x
    beta = np.linalg.solve(xvx, design.x.T @ vi @ design.y)
    rest = design.y - design.x @ beta
    n, p = design.x.shape
    dets = np.linalg.slogdet(v)[1] + np.linalg.slogdet(xvx)[1]
    return float(dets + rest @ vi @ rest + (n - p) * math.log(2 * math.pi))


@pytest.mark.parametrize("formula", FORMULAS)
@pytest.mark.parametrize("singular", [False, True])
def test_fit_is_the_maximum_of_the_dense_likelihood(formula: str, singular: bool) -> None:
    """The criterion is the density's own, and no neighbour on either side is better."""
    design = design_of(generated(3, singular=singular), formula)
    given_ = reml.moments(design)
    assert given_ is not None
    fit = reml.fit(given_, design.blocks)
    best = dense_criterion(design, fit.theta, fit.sigma)
    assert fit.criterion == pytest.approx(best, abs=1e-7)
    generator = np.random.default_rng(1)
    for size in (0.02, 0.1, 0.5, 1.0):
        for _ in range(6):
            theta = fit.theta + size * generator.normal(size=fit.theta.size)
            sigma = fit.sigma * math.exp(0.2 * size * generator.normal())
            assert dense_criterion(design, theta, sigma) >= best - 1e-7


@pytest.mark.parametrize("formula", FORMULAS)
@pytest.mark.parametrize("singular", [False, True])
def test_kenward_roger_equals_its_definition(formula: str, singular: bool) -> None:
    """Dense matrices, the identity as a parameter and differences of Phi give the same."""
    design = design_of(generated(3, singular=singular), formula)
    given_ = reml.moments(design)
    assert given_ is not None
    fit = reml.fit(given_, design.blocks)
    parts = kr.kenward_roger(fit)
    n = len(design.y)
    v = dense_variance(design, fit.theta, fit.sigma)
    bases = [np.eye(n)]
    for block in design.blocks:
        z = design.z[:, block.columns]
        for i, j in itertools.combinations_with_replacement(range(block.size), 2):
            small = np.zeros((block.size, block.size))
            small[i, j] = small[j, i] = 1.0
            bases.append(z @ np.kron(np.eye(block.groups), small) @ z.T)
    x, vi = design.x, np.linalg.inv(v)

    def phi_at(moved: Floats) -> Floats:
        return np.asarray(np.linalg.inv(x.T @ np.linalg.solve(moved, x)))

    phi = phi_at(v)
    p = vi - vi @ x @ phi @ x.T @ vi
    pg = [p @ g for g in bases]
    information = np.array([[0.5 * np.sum(a * b.T) for b in pg] for a in pg])
    w = np.linalg.inv(information)
    h = 1e-4
    slopes = [(phi_at(v + h * g) - phi_at(v - h * g)) / (2 * h) for g in bases]
    total = np.zeros_like(phi)
    for i, j in itertools.product(range(len(bases)), repeat=2):
        pi, pj = (-x.T @ vi @ bases[k] @ vi @ x for k in (i, j))
        q = x.T @ vi @ bases[i] @ vi @ bases[j] @ vi @ x
        total += w[i, j] * (q - pi @ phi @ pj)
    np.testing.assert_allclose(parts.phi, phi, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(parts.adjusted, phi + 2 * phi @ total @ phi, rtol=1e-6, atol=1e-9)
    for term in design.terms:
        contrast = type_three(design, term)
        q_ = contrast.shape[0]
        inner = np.linalg.inv(contrast @ phi @ contrast.T)
        # d(L Phi L')/d gamma = -L Phi P Phi L': the traces of the method, by differences.
        moved = [inner @ contrast @ -slope @ contrast.T for slope in slopes]
        traces = np.array([np.trace(m) for m in moved])
        a1 = float(traces @ w @ traces)
        a2 = float(np.sum(w * np.array([[np.sum(a * b.T) for b in moved] for a in moved])))
        b = (a1 + 6 * a2) / (2 * q_)
        g = ((q_ + 1) * a1 - (q_ + 4) * a2) / ((q_ + 2) * a2)
        c1, c2, c3 = (c / (3 * q_ + 2 * (1 - g)) for c in (g, q_ - g, q_ + 2 - g))
        expected = 1 / (1 - a2 / q_)
        variance = 2 / q_ * (1 + c1 * b) / ((1 - c2 * b) ** 2 * (1 - c3 * b))
        rho = variance / (2 * expected**2)
        df2 = 4 + (q_ + 2) / (q_ * rho - 1)
        distance = contrast @ parts.beta
        wald = distance @ np.linalg.inv(contrast @ parts.adjusted @ contrast.T) @ distance / q_
        result = kr.f_test(parts, contrast)
        assert result.df2 == pytest.approx(df2, rel=1e-4)
        assert result.f == pytest.approx(wald * df2 / (expected * (df2 - 2)), rel=1e-4)


@pytest.mark.parametrize("formula", FORMULAS)
def test_satterthwaite_equals_differences_of_the_dense_likelihood(formula: str) -> None:
    """Information and slopes by differences of n x n algebra give the same df."""
    design = design_of(generated(3), formula)
    given_ = reml.moments(design)
    assert given_ is not None
    fit = reml.fit(given_, design.blocks)
    parts = sw.satterthwaite(fit)
    at = np.append(fit.theta, fit.sigma)
    steps = 1e-3 * np.eye(at.size)

    def phi(point: Floats) -> Floats:
        v = dense_variance(design, point[:-1], float(point[-1]))
        return np.asarray(np.linalg.inv(design.x.T @ np.linalg.solve(v, design.x)))

    def crit(point: Floats) -> float:
        return dense_criterion(design, point[:-1], float(point[-1]))

    hessian = np.array(
        [
            [
                (crit(at + a + b) - crit(at + a - b) - crit(at - a + b) + crit(at - a - b)) / 4e-6
                for b in steps
            ]
            for a in steps
        ]
    )
    variances = 2 * np.linalg.inv(hessian)
    slopes = [(phi(at + s) - phi(at - s)) / 2e-3 for s in steps]
    for place in range(design.x.shape[1]):
        gradient = np.array([slope[place, place] for slope in slopes])
        df = 2 * parts.phi[place, place] ** 2 / (gradient @ variances @ gradient)
        contrast = np.eye(design.x.shape[1])[[place]]
        assert sw.f_test(parts, contrast).df2 == pytest.approx(df, rel=1e-3)


def test_balanced_factorial_has_the_error_terms_of_anova() -> None:
    """On a balanced 3 x 4 design F and df of a, b and a:b are those of the strata."""
    generator = np.random.default_rng(5)
    frame = generated(5, missing=0)
    # Twelve participants' worth of interaction variance keeps every component positive.
    bumps = {
        (p, c): generator.normal(0, 3)
        for p in set(frame["participant"])
        for c in (*FACTORS["a"], *FACTORS["b"])
    }
    extra = [
        bumps[p, a] + bumps[p, b]
        for p, a, b in zip(frame["participant"], frame["a"], frame["b"], strict=True)
    ]
    frame = frame.assign(y=frame["y"] + extra)
    formula = "y ~ a * b + (1 | participant) + (1 | participant:a) + (1 | participant:b)"
    model = mixed_model(frame, formula, FACTORS)
    assert isinstance(model, MixedModel)
    assert not model.singular
    for factor in FACTORS:
        cells = frame.pivot_table(index="participant", columns=factor, values="y").to_numpy()
        n, k = cells.shape
        centred = cells - cells.mean(axis=1, keepdims=True)
        effect = n * np.sum(centred.mean(axis=0) ** 2) / (k - 1)
        error = np.sum((centred - centred.mean(axis=0)) ** 2) / ((k - 1) * (n - 1))
        result = model.test(factor)
        assert result.statistic == pytest.approx(effect / error, rel=1e-6)
        assert result.df1 == k - 1
        assert result.df2 == pytest.approx((k - 1) * (n - 1), rel=1e-6)
    crossed = model.test("a:b")
    whole = 9 * 12 * 3 - 1 - 8 - 2 - 16 - 3 - 24 - 6
    assert crossed.df1 == 6
    assert crossed.df2 == pytest.approx(whole, rel=1e-6)
    satterthwaite = {r.name.split(": ", 1)[1]: r for r in model.satterthwaite}
    assert satterthwaite["a"].df2 == pytest.approx(16, rel=1e-5)
    assert len(model.contrasts) == 3
    assert all(c.p_adjusted is not None and c.p_adjusted >= c.p for c in model.contrasts)


def test_estimates_agree_with_statsmodels_on_unbalanced_data() -> None:
    """Coefficients and variances are MixedLM's at its REML maximum."""
    from statsmodels.regression.mixed_linear_model import MixedLM

    frame = generated(11)
    model = mixed_model(frame, "y ~ a + age + (1 + age | participant)", FACTORS)
    assert isinstance(model, MixedModel)
    exog = np.column_stack(
        [np.ones(len(frame)), frame["a"] == "a1", frame["a"] == "a2", frame["age"]]
    ).astype(float)
    random = exog[:, [0, 3]]
    other = MixedLM(frame["y"].to_numpy(), exog, frame["participant"].to_numpy(), random).fit(
        reml=True, method="nm", maxiter=2000
    )
    # Its other optimisers stop short of this maximum, which is on the boundary.
    assert other.converged
    assert model.criterion == pytest.approx(-2 * other.llf, abs=1e-4)
    ours = [c.estimate for c in model.coefficients]
    np.testing.assert_allclose(ours, other.fe_params, rtol=1e-3, atol=1e-3)
    assert model.components[-1].value == pytest.approx(other.scale, rel=1e-3)


@settings(max_examples=5, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.01, 100), st.floats(-50, 50))
def test_balanced_condition_f_is_the_paired_t_squared(
    seed: int, scale: float, shift: float
) -> None:
    """Not singular and balanced: condition's F is t squared; units, names and order do nothing."""
    generator = np.random.default_rng(seed)
    rows = []
    for person in range(6):
        base, slope = generator.normal(0, 2), generator.normal(0.5, 2)
        for condition, trial in itertools.product((0, 1), range(4)):
            y = base + slope * condition + 0.2 * trial + generator.normal(0, 0.7)
            rows.append((f"P{person}", LEVELS["condition"][condition], trial, y))
    frame = pd.DataFrame(rows, columns=["participant", "condition", "trial", "team_reward"])
    model = trial_model(frame, LEVELS["condition"])
    paired = rm_anova(cell_means(frame, "team_reward", LEVELS["condition"]))
    assert isinstance(model, MixedModel)
    assert isinstance(paired, EffectResult)
    result = model.test("condition")
    if not model.singular:
        assert result.statistic == pytest.approx(paired.statistic, rel=1e-5)
        assert result.df2 == pytest.approx(5, rel=1e-6)
    shuffled = frame.sample(frac=1.0, random_state=seed)
    assert trial_model(shuffled, LEVELS["condition"]) == model
    names = {f"P{k}": f"Q{(k * 5 + 2) % 6}" for k in range(6)}
    changed = frame.assign(
        team_reward=scale * frame["team_reward"] + shift,
        participant=frame["participant"].map(names),
    )
    other = trial_model(changed, LEVELS["condition"])
    assert isinstance(other, MixedModel)
    moved = other.test("condition")
    assert moved.statistic == pytest.approx(result.statistic, rel=1e-4)
    assert moved.df2 == pytest.approx(result.df2, rel=1e-4)
    assert result.estimate is not None
    assert moved.estimate == pytest.approx(scale * result.estimate, rel=1e-6)


def test_missing_trials_are_counted_and_used_without() -> None:
    """A row without a value is left out aloud; the others of its participant are used."""
    frame = study("study192").rename(columns={"reward": "team_reward"})
    frame.loc[[3, 40], "team_reward"] = np.nan
    model = trial_model(frame, LEVELS["condition"])
    assert isinstance(model, MixedModel)
    result = model.test("condition")
    assert result.rows == 190
    assert [(e.count, e.reason) for e in result.rows_excluded] == [(2, "no value of team_reward")]
    assert len(result.participants) == 12


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f[f["participant"].isin(["P01", "P02"])], "at least 3 participants"),
        (lambda f: f[f["condition"] == "manual"], "no rows with condition assisted"),
        (lambda f: f.assign(reward=1.0), "do not scatter"),
        (lambda f: f.assign(reward=np.where(f.index == 5, np.inf, f["reward"])), "not finite"),
        (
            lambda f: f.groupby("participant").sample(1, random_state=1),
            "12 rows for 12 groups of participant",
        ),
        (lambda f: f.assign(tc=1.0), "do not determine the coefficient tc"),
        (lambda f: f.drop(columns="tc"), "no column tc"),
    ],
)
def test_what_cannot_be_fitted_is_refused_in_words(change: Any, words: str) -> None:
    """Each kind of degenerate data is refused with its own reason."""
    model = mixed_model(change(study("study192")), CASES[0][2], LEVELS)
    assert isinstance(model, Refusal)
    assert words in model.reason


@pytest.mark.parametrize("text", ["y x", "y ~ a + (1 participant)", "y ~ a + + b", "y ~ 2a"])
def test_unreadable_formulas_say_what_they_are(text: str) -> None:
    """The message repeats the formula that was given."""
    with pytest.raises(FormulaError, match="y"):
        parse_formula(text)


def test_results_carry_one_formula() -> None:
    """Every test of a model names its formula and the rows it rests on."""
    model = mixed_model(study("study192"), CASES[0][2], LEVELS)
    assert isinstance(model, MixedModel)
    assert {r.formula for r in (*model.tests, *model.satterthwaite)} == {model.formula}
    assert all(dataclasses.is_dataclass(r) and r.rows == 192 for r in model.tests)
