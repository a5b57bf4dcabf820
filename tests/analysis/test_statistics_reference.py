"""Every statistic against what R gives for the same data."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from analysis.statistics.cells import cell_means
from analysis.statistics.likert import LikertRow, likert_rows
from analysis.statistics.pooled_trials import condition_and_trial, condition_trial_order
from analysis.statistics.result import EffectResult
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.wilcoxon import signed_rank

REFERENCE = Path(__file__).parent / "reference"
EXPECTED: dict[str, Any] = json.loads((REFERENCE / "expected.json").read_text())
LEVELS = ("manual", "assisted")
ITEMS = [("Q1", "before"), ("Q2", "before"), ("Q1", "after"), ("Q2", "after")]


def close(value: float | None, expected: float) -> bool:
    assert value is not None
    return value == pytest.approx(expected, rel=1e-5, abs=1e-9)


def read(name: str) -> pd.DataFrame:
    return pd.read_csv(REFERENCE / name, keep_default_na=False)


def trials() -> pd.DataFrame:
    return read("study192.csv").rename(columns={"reward": "team_reward"})


@pytest.fixture(scope="module")
def likert() -> dict[str, LikertRow]:
    answers = read("likert_paper_reconstruction.csv")
    answers = answers.rename(columns={"reveal": "occasion", "rating": "answer"})
    rows = likert_rows(answers, ITEMS, LEVELS)
    return {f"{row.item}_{row.occasion}": row for row in rows}


@pytest.mark.parametrize("key", ["Q1_before", "Q2_before", "Q1_after", "Q2_after"])
def test_likert_rows_match_r(likert: dict[str, LikertRow], key: str) -> None:
    """F, p, difference, interval, every effect size and the exact test agree with R."""
    expected = EXPECTED["likert"][key]
    row = likert[key]
    result = row.f_test
    assert isinstance(result, EffectResult)
    assert (result.df1, result.df2) == (1, 11)
    assert close(result.statistic, expected["F"])
    assert close(result.p, expected["p"])
    assert close(result.estimate, expected["mean_diff"])
    assert result.interval is not None
    assert close(result.interval.low, expected["ci95"][0])
    assert close(result.interval.high, expected["ci95"][1])
    dz = result.effect("d_z")
    assert close(dz.value, expected["dz"]["Cohens_d"])
    assert dz.interval is not None
    assert close(dz.interval.low, expected["dz"]["CI_low"])
    assert close(dz.interval.high, expected["dz"]["CI_high"])
    assert close(result.effect("generalised eta squared").value, expected["rm_anova"]["ges"])
    partial = result.effect("partial eta squared")
    assert close(partial.value, expected["pes"])
    assert partial.interval is not None
    assert partial.interval.low == pytest.approx(expected["pes_ci90"][0], rel=1e-4)
    assert partial.interval.high == pytest.approx(expected["pes_ci90"][1], rel=1e-4)
    assert isinstance(row.rank_test, EffectResult)
    assert close(row.rank_test.p, expected["coin_exact_Wilcoxon"]["p"])
    assert close(row.rank_test.effect("r_rb").value, expected["rank_biserial"])
    assert close(row.holm_p, expected["holm_wilcoxon"])


def test_primary_test_matches_r() -> None:
    """The paired test on 24 participant means agrees with R's RM-ANOVA and t test."""
    expected = EXPECTED["study192"]["paired"]
    result = rm_anova(cell_means(trials(), "team_reward", LEVELS))
    assert isinstance(result, EffectResult)
    assert close(result.statistic, expected["F"])
    assert close(result.p, expected["p"])
    assert close(result.estimate, expected["mean_diff"])
    dz = result.effect("d_z")
    assert close(dz.value, expected["dz"]["Cohens_d"])
    assert dz.interval is not None
    assert close(dz.interval.low, expected["dz"]["CI_low"])
    assert close(dz.interval.high, expected["dz"]["CI_high"])
    assert (result.rows, len(result.participants)) == (24, 12)


def test_wilcoxon_of_team_reward_matches_r() -> None:
    """The exact signed-rank test of the twelve differences agrees with R's coin."""
    cells = cell_means(trials(), "team_reward", LEVELS)
    result = signed_rank(cells.means[:, 1] - cells.means[:, 0], cells.participants)
    assert isinstance(result, EffectResult)
    assert close(result.p, EXPECTED["study192"]["paired"]["coin_exact_Wilcoxon"]["p"])


@pytest.mark.parametrize(
    ("test", "key"),
    [(condition_and_trial, "condition_trial"), (condition_trial_order, "condition_trial_order")],
)
def test_pooled_forms_match_r(test: Any, key: str) -> None:
    """Pooled F on 192 rows has R's value and its 189 or 184 degrees of freedom."""
    expected = EXPECTED["study192"][key]
    result = test(trials(), LEVELS)
    assert isinstance(result, EffectResult)
    assert (result.df1, result.df2, result.rows) == (1, expected["df2"], 192)
    assert close(result.statistic, expected["F"])
    assert close(result.p, expected["p"])
    assert result.role == "comparison"


def test_three_conditions_match_r() -> None:
    """With three conditions F, corrected p, epsilon and effects agree with R's afex."""
    frame = read("within3_nonspherical.csv").rename(columns={"cond": "condition"})
    expected = EXPECTED["within3"]
    result = rm_anova(cell_means(frame, "y", ("c1", "c2", "c3")))
    assert isinstance(result, EffectResult)
    assert close(result.statistic, expected["F"])
    assert close(result.p, expected["p_GG"])
    assert close(result.df1, 2 * expected["GG_eps"])
    assert close(result.df2, 22 * expected["GG_eps"])
    assert close(result.effect("partial eta squared").value, expected["pes"])
    assert close(result.effect("generalised eta squared").value, expected["ges"])


def test_row_order_changes_nothing() -> None:
    """Shuffled rows give the same results to the last bit."""
    frame = trials()
    shuffled = frame.sample(frac=1.0, random_state=np.random.default_rng(7))
    assert not shuffled.index.equals(frame.index)
    for test in (condition_and_trial, condition_trial_order):
        assert test(frame, LEVELS) == test(shuffled, LEVELS)
    first = rm_anova(cell_means(frame, "team_reward", LEVELS))
    assert first == rm_anova(cell_means(shuffled, "team_reward", LEVELS))
