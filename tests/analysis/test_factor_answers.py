"""Ratings and scores by the factors that conditions cross, and figures of several factors."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from analysis.figures.interaction import interaction
from analysis.report import render_report
from analysis.results import StudyResults
from analysis.sections import by_factor
from analysis.statistics.cumulative_link import CumulativeLink, cumulative_link_model
from analysis.statistics.holm import holm
from analysis.statistics.result import EffectResult, Refusal
from analysis.statistics.wilcoxon import signed_rank
from study_results import results_of
from synthetic_study import CROSSED, CROSSED_THREE, CUBED, Plan, study_plans


def planned(conditions: tuple[str, ...], people: int = 6, **more: object) -> Iterator[Plan]:
    return study_plans(
        people, trials=1, timesteps=4, conditions=conditions, phase_four=False, **more
    )


@pytest.fixture(scope="module")
def crossed(tmp_path_factory: pytest.TempPathFactory) -> StudyResults:
    """Allocation by fleet size, seven participants."""
    return results_of(tmp_path_factory.mktemp("crossed"), planned(CROSSED, 7))


def test_each_rating_is_tested_by_factor(crossed: StudyResults) -> None:
    """F is the paired t squared of the contrast, ranks those of averaged levels, Holm over all."""
    assert [one.row for one in crossed.rating_effects] == list(crossed.ratings)
    for one in crossed.rating_effects:
        m4, m12, a4, a12 = (one.row.cells.column(name) for name in CROSSED)
        contrasts = [(a4 + a12 - m4 - m12) / 2, (m12 + a12 - m4 - a4) / 2, (a12 - m12) - (a4 - m4)]
        for effect, values in zip(one.effects, contrasts, strict=True):
            assert isinstance(effect.f_test, EffectResult)
            expected = stats.ttest_1samp(values, 0)
            assert effect.f_test.statistic == pytest.approx(float(expected.statistic) ** 2)
            if "×" in effect.name:
                assert effect.rank_test is None
                continue
            ranks = signed_rank(values, one.row.cells.participants)
            assert isinstance(ranks, EffectResult)
            assert isinstance(effect.rank_test, EffectResult)
            assert effect.rank_test.p == pytest.approx(ranks.p)
    tests = [effect.f_test for one in crossed.rating_effects for effect in one.effects]
    found = [(test.p, test.p_adjusted) for test in tests if isinstance(test, EffectResult)]
    assert len(found) == 12
    assert [p for _, p in found] == pytest.approx(holm([p for p, _ in found]))


def test_the_ordinal_model_of_a_rating_has_both_factors(crossed: StudyResults) -> None:
    """Each effect's likelihood ratio is that of the model of the answers themselves."""
    one = crossed.rating_effects[0]
    asked = crossed.data.responses
    asked = asked[(asked["item"] == one.row.item) & (asked["occasion"] == one.row.occasion)]
    names = asked["condition"].astype(str)
    rows = asked.assign(allocation=names.str.split("_").str[0], robots=names.str.split("_").str[1])
    levels = {"allocation": ("manual", "assisted"), "robots": ("4", "12")}
    model = cumulative_link_model(rows, "answer ~ allocation * robots + (1 | participant)", levels)
    assert isinstance(model, CumulativeLink)
    for effect, test in zip(one.effects, model.tests, strict=True):
        assert isinstance(effect.ordinal, EffectResult)
        assert effect.ordinal.statistic == pytest.approx(test.statistic, abs=1e-6)


def test_scores_are_tested_by_factor(crossed: StudyResults) -> None:
    """The scale has its three effects, and its F is that of its own cells."""
    (one,) = crossed.scale_effects
    assert [effect.name for effect in one.effects] == [
        "Allocation",
        "Fleet size",
        "Allocation × Fleet size",
    ]
    cells = one.row.cells
    change = cells.column("assisted_4") + cells.column("assisted_12")
    change = (change - cells.column("manual_4") - cells.column("manual_12")) / 2
    first = one.effects[0].f_test
    assert isinstance(first, EffectResult)
    assert first.estimate == pytest.approx(float(change.mean()))
    assert all(effect.ordinal is None for effect in one.effects)


def test_the_report_shows_ratings_and_scores_by_factor(crossed: StudyResults) -> None:
    """Words go by the effects, figures and tables stand beside, pairs of conditions do not."""
    page = render_report(crossed)
    assert 'id="figure-rating-factors-title"' in page
    assert 'id="figure-score-factors-title"' in page
    assert "Ratings by factor" in page
    assert "Scores by factor" in page
    assert by_factor.rating_finding(crossed) in page
    assert "Holm’s adjustment over 12 effects" in page
    assert "Each pair of conditions on each item" not in page


def test_one_factor_has_nothing_by_factor(tmp_path: Path) -> None:
    """Two conditions cross nothing, so that the report has no such tables."""
    results = results_of(tmp_path, planned(("manual", "assisted"), 3))
    assert results.rating_effects == ()
    assert results.scale_effects == ()
    assert "By factor" not in render_report(results)


def test_too_few_people_are_refused_for_every_effect(tmp_path: Path) -> None:
    """Two participants give no test, and the report says so in words."""
    results = results_of(tmp_path, planned(CROSSED, 2))
    tests = [e.f_test for one in results.rating_effects for e in one.effects]
    assert tests
    assert all(isinstance(test, Refusal) for test in tests)
    page = render_report(results)
    assert "Effects of factors were not tested." in page


def test_a_factor_of_three_levels_draws_every_difference(tmp_path: Path) -> None:
    """Both other levels stand beside the reference at each fleet size; the caption says so."""
    results = results_of(tmp_path, planned(CROSSED_THREE, 4))
    crossing = results.facts.crossing
    assert crossing is not None
    assert [len(factor.levels) for factor in crossing.factors] == [3, 2]
    markup = interaction("i", crossing, results.cells).markup()
    for a, b in (("suggested_4", "manual_4"), ("assisted_12", "manual_12")):
        mean = float(np.mean(results.cells.column(a) - results.cells.column(b)))
        text = f"{abs(mean):.1f}"
        assert text in markup
    page = render_report(results)
    assert "from left to right Suggested and Assisted, each minus Manual" in page
    assert "Difference from manual" in page


def test_three_factors_are_drawn_in_rows(tmp_path: Path) -> None:
    """Each level of the third factor has its own panels; eight conditions have eight colours."""
    results = results_of(tmp_path, planned(CUBED, 3))
    crossing = results.facts.crossing
    assert crossing is not None
    assert len(crossing.factors) == 3
    markup = interaction("i", crossing, results.cells).markup()
    assert "Mean team reward, 5 timesteps" in markup
    assert "Mean team reward, 15 timesteps" in markup
    page = render_report(results)
    assert "A row for each level of dwell" in page
    assert "f-c7" in page
    assert ".f-c7{" in page
