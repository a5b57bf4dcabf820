"""Power by simulation: the law, the very test, and what it does to the error rates."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.closed_form import closed_form
from analysis.planning.made_up import BLOCK, MadeUp, level_names, make_up
from analysis.planning.power import Cell, run_here, simulate
from analysis.planning.testing import analyse_many, analyse_one
from analysis.robustness import primary_test, reward_tests
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.result import EffectResult, Refusal
from analysis.statistics.rm_anova import rm_anova
from assumed_law import law, three


def cells_of(studies: MadeUp, study: int) -> Cells:
    levels = level_names(studies.places.shape[1])
    return cell_means(studies.frame(study), "team_reward", levels)


def simulated(assumed: Assumptions, size: Design, studies: int, seed: int = 3) -> Cell:
    return simulate(
        [(assumed, size)], run_here, studies=studies, model_studies=studies, seed=seed, stream="t"
    )[0]


def hold(cell: Cell, expected: float, errors: float = 4.0) -> None:
    """Assert that a simulated power is what was expected, within so many standard errors."""
    error = math.sqrt(expected * (1 - expected) / cell.counts.studies)
    assert cell.power == pytest.approx(expected, abs=errors * error)


@pytest.mark.parametrize(
    ("assumed", "size"),
    [
        (law(period=4.0, learning=0.7), Design(12, 8)),
        (law(effects=(0.0, 0.0)), Design(5, 1)),
        (law(drop_out=0.4, missing=0.01, needed=1.0), Design(6, 4)),
        (three(period=2.0, carry_over=3.0), Design(7, 3)),
        (three(drop_out=0.4, needed=1.0), Design(8, 2)),
    ],
    ids=["paired", "smallest", "losses", "three", "three with losses"],
)
def test_many_at_once_are_the_analysis_result_by_result(assumed: Assumptions, size: Design) -> None:
    """p, estimate and refusal are `rm_anova`'s on each study's own table."""
    studies = make_up(assumed, size, 7, "equal", 0)
    found = analyse_many(studies)
    assert not found.by_model.any()
    for study in range(BLOCK):
        expected = rm_anova(cells_of(studies, study))
        if isinstance(expected, Refusal):
            assert np.isnan(found.p[study])
            continue
        assert found.p[study] == pytest.approx(expected.p, rel=1e-9, abs=1e-14)
        if expected.estimate is not None:
            assert found.estimates[study] == pytest.approx(expected.estimate, rel=1e-9)
    if assumed.drop_out:
        assert np.isnan(found.p).any()  # some were left too few: else refusals were not compared


def test_missing_trials_go_to_the_mixed_model_as_in_the_report() -> None:
    """The primary test is that of `reward_tests`, on means or trials as it decides."""
    studies = make_up(law(drop_out=0.2, missing=0.002), Design(6, 3), 7, "model", 0)
    found = analyse_many(studies)
    assert found.by_model.any()
    assert not found.by_model.all()
    for study in range(12):
        frame = studies.frame(study)
        tests = reward_tests(frame, cells_of(studies, study))
        assert tests.primary == primary_test(frame, cells_of(studies, study))
        if isinstance(tests.primary, EffectResult):
            assert (tests.primary.method == "Kenward-Roger") == found.by_model[study]
            assert found.p[study] == pytest.approx(tests.primary.p, rel=1e-9)
        else:
            assert np.isnan(found.p[study])


def test_differences_that_do_not_vary_are_refused() -> None:
    """As `rm_anova` refuses them."""
    studies = make_up(law(effect_sd=0.0), Design(4, 2), 1, "flat", 0)
    studies.rewards[:] = np.arange(2)[None, None, :, None]
    assert isinstance(rm_anova(cells_of(studies, 0)), Refusal)
    assert np.isnan(analyse_many(studies).p).all()


def test_the_law_is_as_stated() -> None:
    """Means, scatter, order and losses of many made-up trials are those assumed."""
    assumed = law(period=3.0, carry_over=2.0, learning=1.5)
    size = Design(400, 6)
    rewards = np.concatenate([make_up(assumed, size, 1, "law", b).rewards for b in range(4)])
    first, second = rewards[:, ::2], rewards[:, 1::2]
    means = rewards.mean(axis=3)
    difference = means[:, :, 1] - means[:, :, 0]
    error = math.sqrt(assumed.difference_variance(6) / difference[:, ::2].size)
    assert difference[:, ::2].mean() == pytest.approx(6 + 3, abs=4 * error)
    assert difference[:, 1::2].mean() == pytest.approx(6 - 3 - 2, abs=4 * error)
    assert difference[:, ::2].var() == pytest.approx(assumed.difference_variance(6), rel=0.02)
    assert (first[..., 5] - first[..., 0]).mean() == pytest.approx(7.5, abs=0.2)
    assert second[..., 0, :].std(axis=2, ddof=0).mean() > 0
    residual = rewards - means[..., None] - 1.5 * (np.arange(6) - 2.5)
    assert math.sqrt(residual.var() * 6 / 5) == pytest.approx(10.5, rel=0.01)
    level = rewards[:, ::2, 0].mean(axis=2)
    assert level.var() == pytest.approx(11**2 + 5**2 / 2 + 10.5**2 / 6, rel=0.03)


def test_losses_are_as_stated() -> None:
    """Who leaves has the trials up to then, in the order run; a rule leaves out whoever has few."""
    size = Design(200, 5)
    made = make_up(law(drop_out=0.3), size, 1, "losses", 0)
    counts = made.there.sum(axis=(2, 3))
    left = counts < 10
    assert left.mean() == pytest.approx(0.3, abs=0.02)
    assert set(np.unique(counts[left])) == set(range(10))
    assert counts[left].mean() == pytest.approx(4.5, abs=0.15)
    second = np.array([order.argmax() for order in made.places])
    for person in (0, 1):  # one of each order
        gone = left[:, person]
        assert not made.there[gone][:, person, second[person], -1].any()
    some = make_up(law(missing=0.1), size, 1, "losses", 0)
    assert 1 - some.there.mean() == pytest.approx(0.1, abs=0.005)
    ruled = make_up(law(drop_out=0.3, needed=0.75), size, 1, "losses", 0)
    assert np.array_equal(ruled.rewards, made.rewards)
    assert np.array_equal(ruled.there.any(axis=(2, 3)), counts >= 8)  # 7.5 of 10


@pytest.mark.parametrize(
    ("assumed", "size"),
    [
        (law(), Design(12, 8)),
        (law(period=6.0, carry_over=-3.0), Design(15, 4)),
        (law(drop_out=0.2, missing=0.005, needed=1.0), Design(20, 8)),
        (law(drop_out=0.2, needed=1.0, period=5.0), Design(10, 16)),
    ],
)
def test_simulation_and_closed_form_agree(assumed: Assumptions, size: Design) -> None:
    """Within Monte-Carlo error, where the closed form is exact."""
    cell = simulated(assumed, size, 20_000)
    assert cell.formula is not None
    assert cell.formula.exact
    hold(cell, cell.formula.power)


def test_three_conditions_lose_little_to_the_correction() -> None:
    """The closed form is not corrected: it is near, and never clearly below."""
    cell = simulated(three(), Design(30, 4), 10_000)
    assert cell.formula is not None
    assert 0 <= cell.formula.power - cell.power + 0.01 < 0.04


@pytest.mark.parametrize("assumed", [law(effects=(0.0, 0.0)), law(effects=(0.0, 0.0), alpha=0.01)])
def test_a_true_null_is_rejected_at_the_level(assumed: Assumptions) -> None:
    """The type I error is alpha within Monte-Carlo error."""
    hold(simulated(assumed, Design(12, 8), 20_000), assumed.alpha)


@pytest.mark.acceptance
def test_a_true_null_with_missing_trials_keeps_the_level() -> None:
    """By the mixed model too."""
    cell = simulated(law(effects=(0.0, 0.0), missing=0.2), Design(8, 3), 100)
    assert cell.counts.by_model == 100
    assert cell.interval.low <= 0.05
    assert cell.formula is None


@pytest.mark.acceptance
def test_losses_cost_power() -> None:
    """Drop-outs, by rule or not, and missing trials."""
    size = Design(10, 3)
    whole = simulated(law(), size, 10_000)
    ruled = simulated(law(drop_out=0.3, needed=1.0), size, 10_000)
    kept = simulated(law(drop_out=0.7), size, 100)
    assert ruled.interval.high < whole.interval.low
    assert kept.interval.high < whole.interval.low
    assert kept.counts.by_model > 90


def test_level_and_learning_cancel_in_complete_data() -> None:
    """Each participant is compared with themself, trial by trial."""
    size = Design(12, 4)
    one = analyse_many(make_up(law(level_sd=0.0), size, 5, "same", 0))
    other = analyse_many(make_up(law(level_sd=50.0, learning=3.0), size, 5, "same", 0))
    assert other.p == pytest.approx(one.p, rel=1e-6)


def test_found_effects_are_exaggerated_where_power_is_low() -> None:
    """With little power only what looks large is found, sometimes with the wrong sign."""
    little = simulated(law(effects=(0.0, 1.0)), Design(6, 2), 10_000)
    much = simulated(law(effects=(0.0, 30.0)), Design(20, 8), 2000)
    assert little.exaggeration is not None
    assert much.exaggeration is not None
    assert little.exaggeration > 3
    assert much.exaggeration == pytest.approx(1.0, abs=0.02)
    assert little.counts.wrong > 0
    assert much.counts.wrong == 0


def test_seeds_tell_studies_apart() -> None:
    """Another seed, stream, size or block gives other studies; the same give the same."""
    size = Design(5, 2)
    base = make_up(law(), size, 1, "a", 0).rewards
    assert np.array_equal(base, make_up(law(), size, 1, "a", 0).rewards)
    for other in (
        make_up(law(), size, 2, "a", 0),
        make_up(law(), size, 1, "b", 0),
        make_up(law(), size, 1, "a", 1),
    ):
        assert not np.intersect1d(base, other.rewards).size
    p, estimate = analyse_one(make_up(law(), size, 1, "a", 0), 0)
    assert 0 <= p <= 1
    assert math.isfinite(estimate)
    assert closed_form(law(), size) is not None
