"""Ordinal models, robustness, orders and designs with several factors, against R."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special

from analysis.statistics.bayes_factor import log_jzs, paired_bayes_factor
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.contrasts import paired_contrasts
from analysis.statistics.crossover import crossover
from analysis.statistics.cumulative_likelihood import Answers, log_likelihood
from analysis.statistics.cumulative_link import CumulativeLink, cumulative_link
from analysis.statistics.equivalence import equivalence
from analysis.statistics.latin_square import LatinSquare, follows_equally, latin_square
from analysis.statistics.leave_one_out import LeaveOneOut, leave_one_out
from analysis.statistics.likert import likert_rows
from analysis.statistics.normality import shapiro_wilk
from analysis.statistics.permutation import sign_flip
from analysis.statistics.reliability import Reliability, cronbach_alpha
from analysis.statistics.result import Check, EffectResult, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.wilcoxon import signed_rank
from analysis.statistics.within import within_anova

REFERENCE = Path(__file__).parent / "reference"
R: dict[str, Any] = json.loads((REFERENCE / "r_results.json").read_text())
LEVELS = ("manual", "assisted")
ITEMS = ["Q1_before", "Q1_after", "Q2_before", "Q2_after"]


def read(name: str) -> pd.DataFrame:
    return pd.read_csv(REFERENCE / f"{name}.csv", keep_default_na=False)


def item(key: str) -> pd.DataFrame:
    name, reveal = key.split("_")
    frame = read("likert_paper_reconstruction").rename(columns={"rating": "answer"})
    return frame[(frame["item"] == name) & (frame["reveal"] == reveal)]


def cells_of(key: str) -> tuple[Cells, dict[str, Any]]:
    if key == "study192":
        return cell_means(read("study192"), "reward", LEVELS), R["study192"]["paired_on_means"]
    cells = cell_means(item(key), "answer", LEVELS)
    return cells, R["likert_paper_reconstruction"]["items"][key]


def made(differences: list[float]) -> Cells:
    means = np.column_stack([np.zeros(len(differences)), differences])
    people = tuple(f"P{place:02d}" for place in range(len(differences)))
    return Cells(people, LEVELS, means, np.ones(means.shape, dtype=np.int64))


@pytest.mark.parametrize("key", ITEMS)
def test_cumulative_link_matches_r(key: str) -> None:
    """Thresholds, log odds, standard error, spread, likelihood and LR agree with clmm."""
    expected = R["likert_paper_reconstruction"]["items"][key]["clmm_nAGQ10"]
    model = cumulative_link(item(key), LEVELS)
    assert isinstance(model, CumulativeLink)
    for label, value in model.thresholds:
        assert value == pytest.approx(expected["coef"][label], rel=1e-3)
    assert model.test.estimate == pytest.approx(expected["coef"]["conditionassisted"], rel=1e-3)
    assert model.test.standard_error == pytest.approx(expected["se"], rel=1e-3)
    assert model.participant_sd == pytest.approx(expected["sd_ranef"], rel=1e-3)
    # Ten nodes are an approximation, which the two programs place a little differently.
    assert model.log_likelihood == pytest.approx(expected["logLik"], rel=1e-5)
    assert model.test.statistic == pytest.approx(expected["LR"], rel=1e-3)
    assert model.test.p == pytest.approx(expected["LR_p"], rel=1e-3)
    assert (model.test.unit, model.test.rows) == ("log odds", 24)


def test_adaptive_quadrature_equals_brute_force() -> None:
    """Ten adaptive nodes integrate as a fine grid over the random effect does."""
    codes = np.array([0, 2, 1, 1, 0, 2])
    x = np.array([[0.0], [1.0]] * 3)
    members = np.kron(np.eye(3), np.ones((2, 1))).astype(np.float64)
    parameters = np.array([[-0.6, 0.9, 0.7, 1.3]])
    grid = np.linspace(-9, 9, 4001)
    bounds = np.array([-1e3, -0.6, 0.9, 1e3])
    total = 0.0
    for person in range(3):
        density = np.exp(-(grid**2) / 2) / math.sqrt(2 * math.pi)
        for row in (2 * person, 2 * person + 1):
            shift = 0.7 * x[row, 0] + 1.3 * grid
            above, below = bounds[codes[row] + 1] - shift, bounds[codes[row]] - shift
            density = density * (special.expit(above) - special.expit(below))
        total += math.log(float(np.trapezoid(density, grid)))
    found = log_likelihood(Answers(codes, 3, x, members), parameters)[0]
    assert found == pytest.approx(total, abs=1e-6)


def test_cumulative_link_refuses_what_has_no_maximum() -> None:
    """Separated answers, one answer and a missing condition are refused in words."""
    rows = [
        {"participant": f"P{p}", "condition": c, "answer": a}
        for p in range(6)
        for c, a in (("manual", 1), ("assisted", 7))
    ]
    separated = cumulative_link(pd.DataFrame(rows), LEVELS)
    assert isinstance(separated, Refusal)
    assert "separated" in separated.reason
    same = cumulative_link(pd.DataFrame(rows).assign(answer=4), LEVELS)
    assert isinstance(same, Refusal)
    assert "same" in same.reason
    one = cumulative_link(pd.DataFrame(rows[::2]), LEVELS)
    assert isinstance(one, Refusal)
    assert "assisted" in one.reason


def test_ratings_are_adjusted_over_the_family() -> None:
    """Holm's p of the F tests and of the exact tests are R's; the models have theirs."""
    frame = read("likert_paper_reconstruction")
    frame = frame.rename(columns={"rating": "answer", "reveal": "occasion"})
    keys = [(name, when) for name in ("Q1", "Q2") for when in ("before", "after")]
    rows = likert_rows(frame, keys, LEVELS)
    expected = R["likert_paper_reconstruction"]
    for row in rows:
        key = f"{row.item}_{row.occasion}"
        assert row.holm_f_p == pytest.approx(expected["holm_t"][key], rel=1e-5)
        assert row.holm_p == pytest.approx(expected["holm_wilcoxon"][key], rel=1e-9)
        assert isinstance(row.ordinal, CumulativeLink)
        assert row.ordinal.test.p_adjusted is not None
        assert row.ordinal.test.p_adjusted >= row.ordinal.test.p


@pytest.mark.parametrize("key", [*ITEMS, "study192"])
def test_robustness_matches_r(key: str) -> None:
    """g_z, Bayes factor, Shapiro-Wilk and two one-sided tests agree with R."""
    cells, expected = cells_of(key)
    paired = rm_anova(cells)
    assert isinstance(paired, EffectResult)
    gz = paired.effect("g_z")
    assert gz.value == pytest.approx(expected["hedges_gz"]["Hedges_g"], rel=1e-5)
    assert gz.interval is not None
    assert gz.interval.low == pytest.approx(expected["hedges_gz"]["CI_low"], rel=1e-5)
    assert gz.interval.high == pytest.approx(expected["hedges_gz"]["CI_high"], rel=1e-5)
    bayes = paired_bayes_factor(cells)
    assert not isinstance(bayes, Refusal)
    assert bayes.bf10 == pytest.approx(expected["BF10_r0.707"], rel=1e-5)
    check = shapiro_wilk(cells)
    assert isinstance(check, Check)
    assert check.statistic == pytest.approx(expected["shapiro"]["W"], rel=1e-5)
    assert check.p == pytest.approx(expected["shapiro"]["p"], rel=1e-4)
    tost = equivalence(cells, expected["tost"]["bound"])
    assert isinstance(tost, EffectResult)
    assert tost.p == pytest.approx(expected["tost"]["p"], rel=1e-5)
    assert tost.interval is not None
    assert tost.interval.low == pytest.approx(expected["tost"]["ci90"][0], rel=1e-5)
    assert tost.interval.high == pytest.approx(expected["tost"]["ci90"][1], rel=1e-5)
    rank = signed_rank(cells.means[:, 1] - cells.means[:, 0], cells.participants)
    assert isinstance(rank, EffectResult)
    assert rank.effect("r_rb").value == pytest.approx(expected["rank_biserial"], rel=1e-9)


def test_equivalence_without_a_bound_is_refused() -> None:
    """No bound, no test; the reason says why one cannot be chosen now."""
    result = equivalence(cells_of("study192")[0], None)
    assert isinstance(result, Refusal)
    assert "states no bound" in result.reason


@pytest.mark.parametrize(("t", "n"), [(0.0, 5), (0.3, 200), (12.0, 12), (60.0, 40)])
def test_bayes_factor_equals_the_integral_over_effects(t: float, n: int) -> None:
    """Quadrature over g equals that over the effect itself, with its Cauchy prior."""
    from scipy import integrate, stats

    scale = math.sqrt(2) / 2
    if t < 30:

        def weighed(d: float) -> float:
            density = stats.nct.pdf(t, n - 1, d * math.sqrt(n)) if d else stats.t.pdf(t, n - 1)
            return float(density * stats.cauchy.pdf(d, 0, scale))

        middle = t / math.sqrt(n)
        width = 12 / math.sqrt(n) + middle
        total, _ = integrate.quad(
            weighed, middle - width, middle + width, points=[middle, 0.0], limit=400
        )
        expected = math.log(total / float(stats.t.pdf(t, n - 1)))
        assert log_jzs(t, n) == pytest.approx(expected, abs=2e-3)
    else:
        assert log_jzs(t, n) > log_jzs(12.0, n) + 10


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(-5, 5), min_size=3, max_size=9))
def test_sign_flips_equal_enumeration(differences: list[int]) -> None:
    """The exact p is the share of sign patterns at least as far from zero."""
    result = sign_flip(made([float(d) for d in differences]))
    if len(set(differences)) == 1:
        assert isinstance(result, Refusal)
        return
    assert isinstance(result, EffectResult)
    observed = abs(sum(differences))
    sums = [
        abs(sum(s * d for s, d in zip(signs, differences, strict=True)))
        for signs in itertools.product((1, -1), repeat=len(differences))
    ]
    assert result.p == pytest.approx(sum(s >= observed for s in sums) / len(sums))


def test_sampled_sign_flips_repeat_and_agree_with_t() -> None:
    """Above twenty participants the sample is seeded, and close to the t test's p."""
    values = list(np.random.default_rng(3).normal(0.4, 1, 24))
    first, second = sign_flip(made(values)), sign_flip(made(values))
    paired = rm_anova(made(values))
    assert isinstance(first, EffectResult)
    assert isinstance(paired, EffectResult)
    assert first == second
    assert first.p == pytest.approx(paired.p, abs=0.01)


def test_leaving_one_out_names_who_matters() -> None:
    """The participant who carries the effect is named, and the range is that of the tests."""
    result = leave_one_out(made([0.1, -0.2, 0.3, 0.0, 9.0]))
    assert isinstance(result, LeaveOneOut)
    assert result.most_influential == "P04"
    assert result.estimates == pytest.approx((0.05, 2.35))
    assert len(result.each) == 5
    assert isinstance(leave_one_out(made([1.0, 2.0, 4.0])), Refusal)


@pytest.mark.parametrize("test", [sign_flip, leave_one_out, shapiro_wilk, paired_bayes_factor])
@pytest.mark.parametrize(
    ("values", "words"),
    [([1.0, 2.0], "at least 3"), ([2.0] * 5, "no variance"), ([1.0, 2.0, math.nan], "finite")],
)
def test_degenerate_differences_are_refused(test: Any, values: list[float], words: str) -> None:
    """Too few, constant or missing differences are refused, everywhere alike."""
    result = test(made(values))
    assert isinstance(result, Refusal)
    assert words in result.reason


def test_alpha_matches_pingouin_and_a_closed_form() -> None:
    """Alpha and its interval are pingouin's; two identical items give one."""
    import pingouin

    scores = np.random.default_rng(2).normal(size=(15, 1)) + np.random.default_rng(3).normal(
        size=(15, 4)
    )
    result = cronbach_alpha(scores, ("a", "b", "c", "d"), "trust")
    assert isinstance(result, Reliability)
    alpha, interval = pingouin.cronbach_alpha(pd.DataFrame(scores))
    assert result.alpha == pytest.approx(alpha, rel=1e-9)
    assert result.interval.low == pytest.approx(interval[0], abs=2e-3)
    assert result.interval.high == pytest.approx(interval[1], abs=2e-3)
    assert set(result.without_item) == {"a", "b", "c", "d"}
    twice = cronbach_alpha(scores[:, [0, 0]], ("a", "b"), "same")
    assert isinstance(twice, Reliability)
    assert twice.alpha == pytest.approx(1.0)
    assert isinstance(cronbach_alpha(np.ones((5, 3)), ("a", "b", "c"), "flat"), Refusal)


def test_crossover_matches_r() -> None:
    """Carry-over, period and the adjusted condition effect agree with R."""
    frame, expected = read("study192"), R["study192"]["crossover_ABBA"]
    cells = cell_means(frame, "reward", LEVELS)
    name = {"MA": LEVELS, "AM": LEVELS[::-1]}
    codes = dict(zip(frame["participant"], frame["order"], strict=True))
    result = crossover(cells, {who: name[code] for who, code in codes.items()})
    assert not isinstance(result, Refusal)
    carry, period, condition = result.carry_over, result.period, result.condition
    assert isinstance(carry, EffectResult)
    assert isinstance(period, EffectResult)
    assert isinstance(condition, EffectResult)
    assert abs(carry.statistic) == pytest.approx(abs(expected["carryover_t"]), rel=1e-5)
    assert carry.p == pytest.approx(expected["carryover_p"], rel=1e-5)
    assert abs(period.statistic) == pytest.approx(abs(expected["period_t"]), rel=1e-5)
    assert period.p == pytest.approx(expected["period_p"], rel=1e-5)
    adjusted = expected["treatment_adj"]
    assert condition.estimate == pytest.approx(adjusted["est"], rel=1e-5)
    assert condition.standard_error == pytest.approx(adjusted["se"], rel=1e-5)
    assert condition.df2 == 10
    assert condition.p == pytest.approx(adjusted["p"], rel=1e-5)
    assert condition.interval is not None
    assert condition.interval.low == pytest.approx(adjusted["ci"][0], rel=1e-5)
    same = crossover(cells, dict.fromkeys(cells.participants, LEVELS))
    assert isinstance(same, Refusal)
    assert "at least two" in same.reason


WILLIAMS = ["abc", "bca", "cab", "cba", "acb", "bac"]


def test_latin_square_finds_what_was_put_in() -> None:
    """With no scatter but a little, condition, period and carry-over are each found alone."""
    orders = {f"P{k:02d}": tuple(WILLIAMS[k % 6]) for k in range(12)}
    assert follows_equally(list(orders.values()), "abc")
    assert not follows_equally([tuple("abc")] * 6, "abc")
    put_in = {"condition": "abc", "period": "", "carry_over": ""}
    for target in put_in:
        generator = np.random.default_rng(4)
        means = np.zeros((12, 3))
        for place, order in enumerate(orders.values()):
            for period, condition in enumerate(order):
                before = order[period - 1] if period else ""
                value = {"condition": condition, "period": "abc"[period], "carry_over": before}
                means[place, "abc".index(condition)] = 5.0 * "abc".find(value[target] or "b")
        means += generator.normal(0, 0.5, means.shape) + generator.normal(0, 9, (12, 1))
        cells = Cells(tuple(orders), tuple("abc"), means, np.ones((12, 3), dtype=np.int64))
        result = latin_square(cells, orders)
        assert isinstance(result, LatinSquare)
        assert result.balanced
        for name in put_in:
            outcome = getattr(result, name)
            assert isinstance(outcome, EffectResult)
            assert (outcome.p < 1e-6) == (name == target)
            assert (outcome.df1, outcome.df2) == (2, 36 - 12 - 6)


def test_latin_square_equals_statsmodels() -> None:
    """F of each term equals the comparison of nested models by statsmodels."""
    from statsmodels.formula.api import ols
    from statsmodels.stats.anova import anova_lm

    generator = np.random.default_rng(8)
    orders = {f"P{k:02d}": tuple(WILLIAMS[k % 6]) for k in range(7)}
    means = generator.normal(size=(7, 3))
    cells = Cells(tuple(orders), tuple("abc"), means, np.ones((7, 3), dtype=np.int64))
    rows = [
        (
            who,
            place,
            c,
            int(place > 0) * ((order[place - 1] == "a") - (order[place - 1] == "c")),
            int(place > 0) * ((order[place - 1] == "b") - (order[place - 1] == "c")),
            means[k, "abc".index(c)],
        )
        for k, (who, order) in enumerate(orders.items())
        for place, c in enumerate(order)
    ]
    frame = pd.DataFrame(rows, columns=["who", "period", "condition", "c1", "c2", "y"])
    whole = ols("y ~ C(who) + C(period) + C(condition) + c1 + c2", frame).fit()
    result = latin_square(cells, orders)
    assert isinstance(result, LatinSquare)
    for name, formula in {
        "condition": "y ~ C(who) + C(period) + c1 + c2",
        "period": "y ~ C(who) + C(condition) + c1 + c2",
        "carry_over": "y ~ C(who) + C(period) + C(condition)",
    }.items():
        table = anova_lm(ols(formula, frame).fit(), whole)
        outcome = getattr(result, name)
        assert outcome.statistic == pytest.approx(table["F"].iloc[1], rel=1e-6)
        assert outcome.p == pytest.approx(table["Pr(>F)"].iloc[1], rel=1e-6)


def test_three_levels_match_r_with_mauchly() -> None:
    """F, both epsilons' p and Mauchly's test agree with R; contrasts are Holm-adjusted."""
    frame = read("within3_nonspherical")
    expected = R["within3_nonspherical"]["rm_anova"][0]
    levels = ("c1", "c2", "c3")
    results = within_anova(frame, "y", {"cond": levels})
    assert isinstance(results, tuple)
    cells = cell_means(frame.rename(columns={"cond": "condition"}), "y", levels)
    for result in (results[0], rm_anova(cells)):
        assert isinstance(result, EffectResult)
        assert result.statistic == pytest.approx(expected["F"], rel=1e-5)
        assert result.p == pytest.approx(expected["p_GG"], rel=1e-5)
        assert result.checks[0].statistic == pytest.approx(expected["mauchly_W"], rel=1e-5)
        assert result.checks[0].p == pytest.approx(expected["mauchly_p"], rel=1e-5)
    contrasts = paired_contrasts(cells)
    assert [c.name for c in contrasts] == ["c2 − c1", "c3 − c1", "c3 − c2"]
    assert all(isinstance(c, EffectResult) and c.p_adjusted is not None for c in contrasts)


def test_three_factors_match_r() -> None:
    """All seven effects of item, reveal and condition agree with R's afex."""
    frame = read("likert_paper_reconstruction")
    factors = {"item": ("Q1", "Q2"), "reveal": ("before", "after"), "condition": LEVELS}
    results = within_anova(frame, "rating", factors)
    assert isinstance(results, tuple)
    for result, expected in zip(
        results, R["likert_paper_reconstruction"]["three_way"], strict=True
    ):
        assert isinstance(result, EffectResult)
        assert result.name == f"RM-ANOVA: {expected['effect']}"
        assert result.statistic == pytest.approx(expected["F"], rel=1e-5)
        assert result.p == pytest.approx(expected["p"], rel=1e-5)
        ges = result.effect("generalised eta squared").value
        assert ges == pytest.approx(expected["ges"], rel=1e-5)


def test_two_factors_match_pingouin() -> None:
    """A 3 x 4 design has pingouin's F, effects, and its epsilon for the main effects."""
    import pingouin

    generator = np.random.default_rng(6)
    rows = [
        (f"P{p}", a, b, generator.normal() + 0.3 * int(a[1]) + p * 0.2 * int(b[1]))
        for p in range(8)
        for a in ("a0", "a1", "a2")
        for b in ("b0", "b1", "b2", "b3")
    ]
    frame = pd.DataFrame(rows, columns=["participant", "a", "b", "y"])
    factors = {"a": ("a0", "a1", "a2"), "b": ("b0", "b1", "b2", "b3")}
    results = within_anova(frame, "y", factors)
    assert isinstance(results, tuple)
    table = pingouin.rm_anova(frame, dv="y", within=["a", "b"], subject="participant")
    table = table.rename(columns=lambda c: str(c).replace("-", "_"))
    for place, result in enumerate(results):
        row = table.iloc[place]
        assert isinstance(result, EffectResult)
        assert result.statistic == pytest.approx(row["F"], rel=1e-6)
        assert result.effect("generalised eta squared").value == pytest.approx(row["ng2"], rel=1e-6)
        if place < 2:
            assert result.df1 == pytest.approx(row["ddof1"] * row["eps"], rel=1e-5)
