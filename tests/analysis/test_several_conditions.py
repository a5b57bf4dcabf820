"""Three and more conditions, and factors that conditions cross: rule, tests and report."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from analysis.factorial import factorial
from analysis.factors import crossed_settings
from analysis.report import render_report
from analysis.results import StudyResults
from analysis.sections import effects, summary
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.friedman import friedman
from analysis.statistics.result import EffectResult, Refusal
from analysis.statistics.rm_anova import rm_anova
from study_results import results_of
from synthetic_study import CROSSED, THREE, Plan, study_plans

REFERENCE = Path(__file__).parent / "reference"


def condition(allocation: str, robots: int = 12, **more: object) -> dict[str, object]:
    settings = {"allocation": allocation, "robots": robots, "view": "tiles", **more}
    return {"name": "_".join(str(value) for value in settings.values()), **settings}


def six(conditions: tuple[str, ...]) -> Iterator[Plan]:
    return study_plans(6, trials=2, timesteps=6, conditions=conditions, phase_four=False)


@pytest.fixture(scope="module")
def crossed(tmp_path_factory: pytest.TempPathFactory) -> StudyResults:
    """Allocation by fleet size, six participants."""
    return results_of(tmp_path_factory.mktemp("crossed"), six(CROSSED))


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> StudyResults:
    """Three allocations, six participants."""
    return results_of(tmp_path_factory.mktemp("three"), six(THREE))


def test_settings_that_take_every_combination_are_factors() -> None:
    """A scorer and a dwell that follow from the allocation are no factors of their own."""
    given = [
        condition(allocation, robots, **settings)
        for robots in (12, 4)
        for allocation, settings in (
            ("manual", {"scorer": "", "dwell": 0}),
            ("assisted", {"scorer": "luce", "dwell": 15}),
        )
    ]
    found = crossed_settings(given)
    assert found is not None
    assert [factor.name for factor in found.factors] == ["allocation", "robots"]
    assert found.factors[0].levels == ("manual", "assisted")
    assert found.factors[1].level_labels == ("4 robots", "12 robots")
    assert found.condition(("assisted", "4")) == given[3]["name"]
    assert found.label("allocation:robots") == "Allocation × Fleet size"


def test_three_factors_are_found() -> None:
    """Two values each of three settings in eight conditions cross."""
    given = [
        condition(allocation, robots, scorer=scorer)
        for allocation, robots, scorer in itertools.product(
            ("suggested", "assisted"), (4, 12), ("luce", "random")
        )
    ]
    found = crossed_settings(given)
    assert found is not None
    assert [factor.name for factor in found.factors] == ["allocation", "scorer", "robots"]


@pytest.mark.parametrize(
    "given",
    [
        [condition("manual"), condition("assisted")],
        [condition("manual"), condition("suggested"), condition("assisted")],
        # One cell is missing.
        [condition("manual", 4), condition("manual"), condition("assisted", 4)],
        # One cell is there twice.
        [condition("manual", 4), condition("manual", 4), condition("assisted"), condition("a")],
        # The scorer differs on the side: fleet sizes of assisted are not alike but for it.
        [
            condition("manual", 4),
            condition("manual", 12),
            condition("assisted", 4, scorer="luce"),
            condition("assisted", 12, scorer="classifier"),
        ],
    ],
)
def test_what_is_not_crossed_is_one_factor(given: list[dict[str, object]]) -> None:
    """Without every combination, or with another setting differing on the side, nothing crosses."""
    assert crossed_settings(given) is None


def made_up(seed: int, people: int = 9, trials: int = 4) -> pd.DataFrame:
    """Return trials of two crossed factors with an effect of each between people."""
    generator = np.random.default_rng(seed)
    rows = []
    for person in range(people):
        level, gain, size, both = generator.normal([50, 6, -4, 3], [8, 9, 9, 6])
        for block, name in enumerate(CROSSED, start=1):
            a, b = name.startswith("assisted"), name.endswith("_12")
            cell = level + gain * a + size * b + both * (a - 0.5) * (b - 0.5)
            cell += generator.normal(0, 5)
            for trial in range(1, trials + 1):
                value = cell + generator.normal(0, 3)
                rows.append((f"P{person}", name, 1 + (block + person) % 4, trial, value))
    columns = ["participant", "condition", "block", "trial", "team_reward"]
    return pd.DataFrame(rows, columns=columns)


CROSSING = crossed_settings(
    [
        {"name": name, "allocation": name.split("_")[0], "robots": int(name.split("_")[1])}
        for name in CROSSED
    ]
)


def test_each_effect_is_a_paired_test_of_its_contrast() -> None:
    """Main effect and interaction are paired t tests of the averaged means, R's and ours."""
    trials = made_up(3)
    cells = cell_means(trials, "team_reward", CROSSED)
    found = factorial(CROSSING, trials, cells)
    assert found is not None
    m4, m12, a4, a12 = (cells.column(name) for name in CROSSED)
    contrasts = [(a4 + a12 - m4 - m12) / 2, (m12 + a12 - m4 - a4) / 2, (a12 - m12) - (a4 - m4)]
    for effect, values in zip(found.means, contrasts, strict=True):
        assert isinstance(effect, EffectResult)
        expected = stats.ttest_1samp(values, 0)
        bounds = expected.confidence_interval(0.95)
        assert effect.estimate == pytest.approx(float(values.mean()))
        assert effect.statistic == pytest.approx(float(expected.statistic) ** 2)
        assert effect.p == pytest.approx(float(expected.pvalue))
        assert effect.interval is not None
        assert [effect.interval.low, effect.interval.high] == pytest.approx(list(bounds))
    names = [effect.name for effect in found.means]
    assert names == ["Allocation", "Fleet size", "Allocation × Fleet size"]
    assert len(found.simple) == 4
    last = found.simple[1]
    assert isinstance(last, EffectResult)
    assert last.name == "Assisted − Manual, at 12 robots"
    assert last.estimate == pytest.approx(float((a12 - m12).mean()))


def test_the_mixed_model_gives_the_same_f_on_balanced_data() -> None:
    """Each effect of factors has the error term in the trials that it has in the means."""
    trials = made_up(5, people=16).assign(block=1)
    cells = cell_means(trials, "team_reward", CROSSED)
    found = factorial(CROSSING, trials, cells)
    assert found is not None
    for means, model in zip(found.means, found.trials, strict=True):
        assert isinstance(means, EffectResult)
        assert isinstance(model, EffectResult)
        assert model.statistic == pytest.approx(means.statistic, rel=1e-4)
        assert model.df2 == pytest.approx(means.df2, rel=1e-3)


def test_a_model_without_degrees_of_freedom_is_refused(tmp_path: Path) -> None:
    """Four people with one trial a cell leave the model nothing to test against."""
    plans = study_plans(4, trials=1, timesteps=4, conditions=CROSSED, phase_four=False)
    results = results_of(tmp_path, plans)
    assert results.factorial is not None
    outcomes = (*results.sensitivity, *results.factorial.trials)
    refused = [test for test in outcomes if isinstance(test, Refusal)]
    assert any("no degrees of freedom are left" in test.reason for test in refused)
    assert "no degrees of freedom are left" in render_report(results)


def test_friedman_agrees_with_r() -> None:
    """Ranks of the reference's three levels give R's chi-squared; ties agree with SciPy's."""
    expected = json.loads((REFERENCE / "r_results.json").read_text())["within3_nonspherical"]
    frame = pd.read_csv(REFERENCE / "within3_nonspherical.csv", keep_default_na=False)
    frame = frame.rename(columns={"cond": "condition", "id": "participant"})
    levels = sorted(set(frame["condition"]))
    result = friedman(cell_means(frame, "y", levels))
    assert isinstance(result, EffectResult)
    assert result.statistic == pytest.approx(expected["friedman"]["chi2"], rel=1e-9)
    assert result.p == pytest.approx(expected["friedman"]["p"], rel=1e-9)
    ties = np.random.default_rng(1).integers(1, 4, size=(8, 3)).astype(float)
    who = tuple(f"P{n}" for n in range(8))
    found = friedman(Cells(who, ("a", "b", "c"), ties, np.ones((8, 3), dtype=np.int64)))
    assert isinstance(found, EffectResult)
    assert found.statistic == pytest.approx(float(stats.friedmanchisquare(*ties.T).statistic))
    same = Cells(who, ("a", "b", "c"), np.ones((8, 3)), np.ones((8, 3), dtype=np.int64))
    assert isinstance(friedman(same), Refusal)


def test_the_report_tests_factors(crossed: StudyResults) -> None:
    """A crossing is named, drawn and tested; the headline goes by its effects."""
    assert crossed.facts.crossing is not None
    assert crossed.factorial is not None
    assert all(isinstance(effect, EffectResult) for effect in crossed.factorial.means)
    adjusted = [effect.p_adjusted for effect in effects.effects(crossed)]
    assert all(p is not None for p in adjusted)
    page = render_report(crossed)
    assert "Allocation (Manual, Assisted) crossed with fleet size (4 robots, 12 robots)" in page
    assert 'id="figure-interaction-title"' in page
    assert "rule crossed_settings" in page
    assert summary.headline(crossed) == effects.effects_in_words(crossed)
    assert "allocation" in summary.headline(crossed).lower()


def test_the_report_tests_pairs_of_three_conditions(three: StudyResults) -> None:
    """Every pair stands in figure and table with Holm's p; ratings go by the corrected F."""
    assert three.facts.crossing is None
    assert three.factorial is None
    pairs = effects.pairs(three)
    assert [pair.name for pair in pairs] == [
        "Suggested − Manual",
        "Assisted − Manual",
        "Assisted − Suggested",
    ]
    first = rm_anova(three.cells.keep(("manual", "suggested")))
    assert isinstance(first, EffectResult)
    assert pairs[0].p == pytest.approx(first.p)
    assert (pairs[0].p_adjusted or 0) >= pairs[0].p
    page = render_report(three)
    assert 'id="figure-pairs-title"' in page
    assert "Kendall’s" in page
    assert "the corrected F test with Holm’s adjustment" in page
    assert "Not tested" not in page
    for row in three.ratings:
        assert len(row.pairs) == 3


def test_conditions_that_nobody_ran_are_still_planned(tmp_path: Path) -> None:
    """A session that broke off before any condition does not make the plan one of no trials."""
    plan = Plan("P01", 0, trials=3, timesteps=4, planned=2, stop_after=5)
    results = results_of(tmp_path, [plan])
    tiles = {tile.name: tile for tile in summary.tiles(results)}
    assert tiles["trials analysed"].of == "of 12 planned"
    assert not tiles["trials analysed"].good
