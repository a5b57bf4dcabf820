"""The statistics on data frames of any origin: examples, refusals in words, and R's conventions."""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special, stats

from analysis.statistics.cells import cell_means
from analysis.statistics.cumulative_likelihood import Answers, log_likelihood
from analysis.statistics.cumulative_link import CumulativeLink, cumulative_link_model
from analysis.statistics.mixed.design import build_design, type_three
from analysis.statistics.mixed.formula import parse_formula
from analysis.statistics.mixed.kenward_roger import KenwardRoger, f_test
from analysis.statistics.mixed.model import MixedModel, mixed_model
from analysis.statistics.result import EffectResult, Refusal
from analysis.statistics.within import within_anova
from study.errors import StudyError

ROOT = Path(__file__).parents[2]
REFERENCE = Path(__file__).parent / "reference"
R: dict[str, Any] = json.loads((REFERENCE / "r_results.json").read_text())
LEVELS: dict[str, tuple[object, ...]] = {"a": ("x", "y", "z"), "b": (1, 2, 3, 4)}
FORMULA = "y ~ a * b + age + (1 | subject)"


def made_up(people: int = 8, seed: int = 0) -> pd.DataFrame:
    """Return 3 x 4 rows a person with a covariate, an answer and a number."""
    generator = np.random.default_rng(seed)
    rows = [
        (f"S{p}", a, b, generator.normal(), generator.integers(1, 6), generator.normal() + p / 5)
        for p in range(people)
        for a in LEVELS["a"]
        for b in LEVELS["b"]
    ]
    return pd.DataFrame(rows, columns=["subject", "a", "b", "age", "rate", "y"])


def test_the_examples_of_the_how_to_run(capsys: pytest.CaptureFixture[str]) -> None:
    """Every block of the page runs, one after the other, and gives numbers."""
    page = (ROOT / "docs" / "how-to" / "use-the-statistics.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for block in re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE):
        exec(block, names)  # noqa: S102 - the page is ours
    printed = capsys.readouterr().out
    assert "RM-ANOVA: allocation:robots: F(" in printed
    assert "allocation:robots, Kenward-Roger: F(6, " in printed
    assert "robots: chi2(3) = " in printed
    assert isinstance(names["model"], MixedModel)
    assert "nan" not in printed


@pytest.mark.parametrize(
    ("change", "formula", "levels", "words"),
    [
        (lambda f: f.drop(columns="age"), FORMULA, LEVELS, "no column age"),
        (lambda f: f.assign(age="old"), FORMULA, LEVELS, "age does not hold numbers"),
        (lambda f: f, FORMULA, {"b": LEVELS["b"]}, "If it is a factor, name its levels"),
        (lambda f: f, FORMULA, {**LEVELS, "a": "xyz"}, "given as one text"),
        (lambda f: f, FORMULA, {**LEVELS, "a": ("x",)}, "two or more different levels"),
        (lambda f: f, FORMULA, {**LEVELS, "a": ("x", "x")}, "two or more different levels"),
        (lambda f: f, FORMULA, {**LEVELS, "a": ("q", "r")}, "the rows hold x, y, z"),
        (lambda f: f, FORMULA, {**LEVELS, "a": ("x", "w")}, "no rows with a w"),
        (lambda f: f.assign(y=np.nan), FORMULA, LEVELS, "No row has a value"),
        (lambda f: f.iloc[:0], FORMULA, LEVELS, "No row has a value"),
        (lambda f: pd.concat([f, f[["y"]]], axis=1), FORMULA, LEVELS, "more than one column y"),
        (lambda f: f, "y ~ 0 + a + (1 | subject)", LEVELS, "intercept is always part"),
        (lambda f: f, "y ~ I(age) + (1 | subject)", LEVELS, "not the name of a column"),
        (lambda f: f, "y ~ a", LEVELS, "no random term"),
    ],
)
def test_a_mixed_model_refuses_bad_input_in_words(
    change: Callable[[pd.DataFrame], pd.DataFrame], formula: str, levels: Any, words: str
) -> None:
    """What is wrong about a frame, a formula or levels is said, never raised."""
    found = mixed_model(change(made_up()), formula, levels)
    assert isinstance(found, Refusal)
    assert words in found.reason


def test_factors_may_be_stored_as_numbers_and_participants_named_otherwise() -> None:
    """Whole numbers as floats, integers, text or categories are the same levels."""
    frame = made_up()
    models = [
        mixed_model(frame.assign(b=made), FORMULA, LEVELS)
        for made in (
            frame["b"],
            frame["b"].astype(float),
            frame["b"].astype(str),
            frame["b"].astype("category"),
        )
    ]
    assert all(isinstance(model, MixedModel) for model in models)
    assert all(model == models[0] for model in models)
    left = mixed_model(frame.assign(y=frame["y"].where(frame["subject"] != "S3")), FORMULA, LEVELS)
    assert isinstance(left, MixedModel)
    assert [one.participant for one in left.tests[0].excluded] == ["S3"]


def test_pairs_of_every_factor_are_compared() -> None:
    """A 3 x 4 model gives three and six pairs, averaged over the other factor."""
    frame = made_up()
    model = mixed_model(frame, "y ~ a * b + (1 | subject)", LEVELS)
    assert isinstance(model, MixedModel)
    assert [len(pairs) for pairs in model.pairs.values()] == [3, 6]
    means = frame.groupby("b")["y"].mean()
    first = model.pairs["b"][0]
    assert first.name == "Mixed model: 2 − 1"
    assert first.estimate == pytest.approx(means[2] - means[1])
    assert model.contrasts == model.pairs["a"]


def test_effects_without_correlation_are_separate_terms() -> None:
    """(1 + age || subject) is (1 | subject) + (0 + age | subject), as in lme4."""
    short = mixed_model(made_up(), "y ~ a + age + (1 + age || subject)", LEVELS)
    long = mixed_model(made_up(), "y ~ a + age + (1 | subject) + (0 + age | subject)", LEVELS)
    assert isinstance(short, MixedModel)
    assert isinstance(long, MixedModel)
    assert short.criterion == long.criterion
    assert len(short.components) == 3


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda f: within_anova(f, "y", LEVELS), "one column 'participant'"),
        (lambda f: within_anova(f, "yy", LEVELS, participant="subject"), "one column 'yy'"),
        (lambda f: within_anova(f, "y", {"c": (1, 2)}, participant="subject"), "no column 'c'"),
        (lambda f: within_anova(f, "y", {"a": "xy"}, participant="subject"), "different levels"),
        (lambda f: within_anova(f, "y", {}, participant="subject"), "no factor"),
        (lambda f: cell_means(f, "a", ("x", "y"), participant="subject", condition="a"), "numbers"),
        (lambda f: cell_means(f, "y", "xy", participant="subject", condition="a"), "one text"),
        (lambda f: cell_means(f, "y", ("x", "x"), participant="subject", condition="a"), "twice"),
    ],
)
def test_calls_that_data_cannot_explain_raise_words(
    call: Callable[[pd.DataFrame], object], words: str
) -> None:
    """A column or levels that are not there are an error of the call, said in words."""
    with pytest.raises(StudyError, match=re.escape(words)):
        call(made_up())


def test_an_effect_without_variance_is_refused_in_its_place() -> None:
    """Where one effect is the same for everybody, the others are still tested."""
    generator = np.random.default_rng(2)
    rows = [
        (f"S{p}", a, b, level + slope * b + 3 * a)
        for p, (level, slope) in enumerate(generator.normal(size=(6, 2)))
        for a in (0, 1)
        for b in (0, 1)
    ]
    frame = pd.DataFrame(rows, columns=["participant", "a", "b", "y"])
    found = within_anova(frame, "y", {"a": (0, 1), "b": (0, 1)})
    assert isinstance(found, tuple)
    assert [isinstance(effect, EffectResult) for effect in found] == [False, True, False]


def test_mauchly_of_three_by_four_is_as_r_prints_it() -> None:
    """W and p follow R's code, which puts the number of cells into Anderson's expansion."""
    frame = made_up(14).rename(columns={"subject": "participant"})
    results = within_anova(frame, "y", LEVELS)
    assert isinstance(results, tuple)
    wide = frame.pivot_table(index="participant", columns=["a", "b"], values="y").to_numpy()
    ssd = np.cov(wide, rowvar=False) * 13
    a = np.array([[1, 0], [0, 1], [-1, -1]], dtype=float)  # contr.sum
    b = np.vstack([np.eye(3), -np.ones(3)])
    for result, p_matrix in zip(
        results,
        (np.kron(a, np.ones((4, 1))), np.kron(np.ones((3, 1)), b), np.kron(a, b)),
        strict=True,
    ):
        pp, p, n = p_matrix.shape[1], 12, 13
        u = np.linalg.solve(p_matrix.T @ p_matrix, p_matrix.T @ ssd @ p_matrix)
        log_w = math.log(np.linalg.det(u)) - pp * math.log(np.trace(u) / pp)
        rho = 1 - (2 * pp**2 + pp + 2) / (6 * pp * n)
        w2 = (pp + 2) * (pp - 1) * (pp - 2) * (2 * pp**3 + 6 * pp**2 + 3 * p + 2)
        w2 /= 288 * (n * pp * rho) ** 2
        z, df = -n * rho * log_w, pp * (pp + 1) / 2 - 1
        first = float(stats.chi2.sf(z, df))
        expected = first + w2 * (float(stats.chi2.sf(z, df + 4)) - first)
        assert isinstance(result, EffectResult)
        (check,) = result.checks
        assert check.statistic == pytest.approx(math.exp(log_w), rel=1e-8)
        assert check.p == pytest.approx(expected, rel=1e-8)
        eigen = np.linalg.eigvals(u).real
        epsilon = eigen.sum() ** 2 / (pp * (eigen**2).sum())
        assert result.df1 == pytest.approx(pp * epsilon, rel=1e-8)


@pytest.mark.parametrize(
    "formula", ["y ~ a * b + age", "y ~ a * age", "y ~ a * b * age", "y ~ a + b + age"]
)
def test_type_three_contrasts_are_those_of_lmertest(formula: str) -> None:
    """The full indicator design, made orthogonal to what contains a term, gives the same rows."""
    frame = made_up().sample(60, random_state=1)
    parsed = parse_formula(f"{formula} + (1 | subject)")
    levels = {name: tuple(str(level) for level in known) for name, known in LEVELS.items()}
    used = {name: known for name, known in levels.items() if name in parsed.names}
    keyed = frame.assign(b=frame["b"].astype(str))
    design = build_design(keyed, parsed, used)
    ordered = keyed.sort_values([*parsed.names, "y"], kind="stable").reset_index(drop=True)
    blocks: list[tuple[tuple[str, ...], np.ndarray]] = [((), np.ones((len(ordered), 1)))]
    for term in parsed.terms:
        factors = [name for name in term if name in used]
        base = np.ones(len(ordered))
        for name in (name for name in term if name not in used):
            base = base * ordered[name].to_numpy()
        columns = [
            base
            * np.prod([(ordered[f] == lv) for f, lv in zip(factors, cell, strict=True)], axis=0)
            for cell in itertools.product(*(used[name] for name in factors))
        ]
        blocks.append((term, np.column_stack(columns)))
    whole = np.column_stack([block for _, block in blocks])
    owners = [term for term, block in blocks for _ in range(block.shape[1])]
    general = (np.linalg.pinv(design.x) @ whole).T
    places = {t: [i for i, c in enumerate(design.columns) if c.term == t] for t in parsed.terms}

    def holds(outer: tuple[str, ...], inner: tuple[str, ...]) -> bool:
        numbers = ({n for n in t if n not in used} for t in (outer, inner))
        groups = [{n for n in t if n in used} for t in (outer, inner)]
        return len({frozenset(n) for n in numbers}) == 1 and groups[1] < groups[0]

    for term in sorted(parsed.terms, key=len, reverse=True):
        outer = [p for other in parsed.terms if holds(other, term) for p in places[other]]
        if outer:
            own, basis = general[:, places[term]], general[:, outer]
            general[:, places[term]] = own - basis @ np.linalg.lstsq(basis, own, rcond=None)[0]
    kept = [
        next(
            j
            for j, owner in enumerate(owners)
            if owner == column.term and np.allclose(whole[:, j], design.x[:, i])
        )
        for i, column in enumerate(design.columns)
    ]
    for term in parsed.terms:
        rows = general[kept][:, places[term]].T
        np.testing.assert_allclose(type_three(design, term), rows, atol=1e-8)


def test_kenward_rogers_quotients_by_zero_are_not_raised() -> None:
    """Where the method's divisor is exactly zero the result is not finite, as in R."""
    one = np.eye(1)
    # With one contrast a2 = a1 = w, and the divisor is 1 - 2 w.
    found = f_test(KenwardRoger(np.ones(1), one, one, [-one], np.array([[0.5]])), one)
    assert found.df2 == pytest.approx(4.0)


def test_laplace_agrees_with_r_where_r_converges() -> None:
    """One node is Laplace's approximation; clmm stops its inner search early, so to 1e-3."""
    frame = pd.read_csv(REFERENCE / "likert_paper_reconstruction.csv", keep_default_na=False)
    frame = frame[(frame["item"] == "Q1") & (frame["reveal"] == "after")]
    expected = R["likert_paper_reconstruction"]["items"]["Q1_after"]["clmm_nAGQ1"]
    levels = {"condition": ("manual", "assisted")}
    model = cumulative_link_model(frame, "rating ~ condition + (1 | participant)", levels, nodes=1)
    assert isinstance(model, CumulativeLink)
    (one,) = model.coefficients
    assert one.name == "conditionassisted"
    assert one.estimate == pytest.approx(expected["coef"]["conditionassisted"], rel=1e-3)
    assert one.standard_error == pytest.approx(expected["se"], rel=1e-3)
    assert model.log_likelihood == pytest.approx(expected["logLik"], abs=1e-4)


def test_an_ordinal_model_tests_terms_and_scales_with_its_covariate() -> None:
    """The interaction's ratio is that of nested models; a covariate's unit changes no test."""
    frame = made_up(10, seed=4)
    whole = cumulative_link_model(frame, "rate ~ a * b + age + (1 | subject)", LEVELS)
    nested = cumulative_link_model(frame, "rate ~ a + b + age + (1 | subject)", LEVELS)
    moved = frame.assign(age=40 + 1000 * frame["age"])
    other = cumulative_link_model(moved, "rate ~ a * b + age + (1 | subject)", LEVELS)
    assert isinstance(whole, CumulativeLink)
    assert isinstance(nested, CumulativeLink)
    assert isinstance(other, CumulativeLink)
    assert [test.df1 for test in whole.tests] == [2, 3, 1, 6]
    ratio = 2 * (whole.log_likelihood - nested.log_likelihood)
    assert whole.tests[-1].statistic == pytest.approx(ratio, abs=1e-6)
    for one, two in zip(whole.tests, other.tests, strict=True):
        assert one.statistic == pytest.approx(two.statistic, abs=1e-5)
    ours, theirs = (next(c for c in m.coefficients if c.name == "age") for m in (whole, other))
    assert theirs.estimate == pytest.approx(ours.estimate / 1000, rel=1e-4)
    assert theirs.z == pytest.approx(ours.z, rel=1e-4)
    shift = theirs.estimate * 40
    assert other.thresholds[0][1] == pytest.approx(whole.thresholds[0][1] + shift, rel=1e-3)


@pytest.mark.parametrize(
    ("formula", "change", "nodes", "words"),
    [
        ("rate ~ a + (1 | subject) + (1 | subject:a)", lambda f: f, 10, "one random term"),
        ("rate ~ a + (1 + age | subject)", lambda f: f, 10, "one random term"),
        ("y ~ a + (1 | subject)", lambda f: f, 10, "not whole"),
        ("rate ~ a + (1 | subject)", lambda f: f, 0, "one node or more"),
        ("rate ~ a + (1 | subject)", lambda f: f.assign(rate=3), 10, "Every answer is the same"),
        ("rate ~ a + (1 | subject)", lambda f: f[f["a"] != "y"], 10, "no answers under y"),
        ("rate ~ a + (1 | subject)", lambda f: f[f["subject"] < "S2"], 10, "3 participants"),
    ],
)
def test_an_ordinal_model_refuses_in_words(
    formula: str, change: Callable[[pd.DataFrame], pd.DataFrame], nodes: int, words: str
) -> None:
    """Other random effects, numbers that are no answers and too little data are refused."""
    found = cumulative_link_model(change(made_up()), formula, LEVELS, nodes=nodes)
    assert isinstance(found, Refusal)
    assert words in found.reason


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 10_000),
    st.floats(0.01, 12),
    st.sampled_from([-1.0, 1.0]),
    st.lists(st.integers(0, 3), min_size=2, max_size=5),
)
def test_the_ordinal_likelihood_is_the_integral(
    seed: int, spread: float, sign: float, answers: list[int]
) -> None:
    """Any spread, on either sign, alone or in a batch: quadrature about the true mode."""
    alpha = np.array([-1.2, 0.3, 1.9])
    codes = np.array(answers)
    given_ = Answers(codes, 4, np.zeros((len(codes), 0)), np.ones((len(codes), 1)), 60)
    point = np.array([*alpha, sign * spread])
    generator = np.random.default_rng(seed)
    others = [np.array([*alpha, generator.normal(0, 6)]) for _ in range(3)]
    alone = float(log_likelihood(given_, point[None, :])[0])
    batch = log_likelihood(given_, np.array([*others, point, *others]))
    assert batch[3] == pytest.approx(alone, abs=1e-10)
    grid = np.linspace(-9, 9, 20001)
    bounds = np.array([-300, *alpha, 300.0])
    density = stats.norm.logpdf(grid)
    for code in codes:
        up, down = bounds[code + 1] - spread * grid, bounds[code] - spread * grid
        gap = np.log(-np.expm1(-(bounds[code + 1] - bounds[code])))
        density = density + special.log_expit(up) + special.log_expit(-down) + gap
    assert alone == pytest.approx(math.log(float(np.trapezoid(np.exp(density), grid))), abs=2e-3)


def test_a_search_that_meets_no_spread_goes_on() -> None:
    """The likelihood at the maximum is at least that of any spread, with all else as found."""
    for seed in range(6):
        frame = made_up(9, seed=seed).assign(
            rate=lambda f: np.clip(np.rint(2.5 + f["y"] + (f["a"] == "z")), 1, 5)
        )
        model = cumulative_link_model(frame, "rate ~ a + (1 | subject)", LEVELS)
        assert isinstance(model, CumulativeLink)
        people = np.array(sorted(set(frame["subject"])))
        members = np.array([people == who for who in frame["subject"]], dtype=np.float64)
        x = np.column_stack([np.where(frame["a"] == level, 1.0, 0.0) for level in ("y", "z")])
        categories, codes = np.unique(frame["rate"], return_inverse=True)
        answers = Answers(codes, len(categories), x, members)
        fixed = [value for _, value in model.thresholds]
        fixed += [one.estimate for one in model.coefficients]
        spreads = np.array([[*fixed, spread] for spread in (0.0, 0.05, 0.2, 0.5, 1.0, 2.0)])
        assert model.log_likelihood >= log_likelihood(answers, spreads).max() - 1e-9
