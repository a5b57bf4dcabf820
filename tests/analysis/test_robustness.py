"""Which test of team reward is primary, and what stands beside it."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from analysis.recordings import StudyRecordings
from analysis.report import render_report
from analysis.results import StudyResults, compute_results
from analysis.robustness import order_tests, reward_tests, robustness
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.crossover import Crossover
from analysis.statistics.latin_square import LatinSquare
from analysis.statistics.result import EffectResult
from analysis.statistics.rm_anova import rm_anova
from analysis.tables.study_tables import StudyTables

LEVELS = ("manual", "assisted")
MODEL = "Mixed model of trials, Kenward-Roger"
PAIRED = "Participant means, paired (RM-ANOVA)"


@pytest.fixture
def trials() -> pd.DataFrame:
    """Twelve participants, two conditions, eight trials."""
    frame = pd.read_csv(Path(__file__).parent / "reference" / "study192.csv")
    return frame.rename(columns={"reward": "team_reward", "period": "block"})


def names(trials: pd.DataFrame) -> tuple[str, list[str]]:
    """Return the primary test's name and the names of the others."""
    cells = cell_means(trials, "team_reward", LEVELS)
    tests = reward_tests(trials, cells)
    assert isinstance(tests.primary, EffectResult)
    assert tests.primary.role == "primary"
    assert all(getattr(test, "role", "sensitivity") == "sensitivity" for test in tests.sensitivity)
    return tests.primary.name, [test.name for test in tests.sensitivity]


def test_means_are_primary_where_nobody_lacks_a_trial(trials: pd.DataFrame) -> None:
    """The mixed model, both rank and sign tests stand beside them."""
    primary, others = names(trials)
    assert primary == PAIRED
    assert others == [
        MODEL,
        "Mixed model of trials, Satterthwaite",
        "Exact Wilcoxon",
        "Sign-flip permutation",
    ]


def test_the_model_is_primary_where_a_trial_is_missing(trials: pd.DataFrame) -> None:
    """The test of the means is then sensitivity."""
    primary, others = names(trials.drop(index=trials.index[3]))
    assert primary == MODEL
    assert others[0] == PAIRED


def test_the_model_is_primary_where_a_condition_is_missing(trials: pd.DataFrame) -> None:
    """Who lacks a condition counts in the model only."""
    who = trials["participant"].iloc[0]
    fewer = trials[(trials["participant"] != who) | (trials["condition"] == "manual")]
    cells = cell_means(fewer, "team_reward", LEVELS)
    tests = reward_tests(fewer, cells)
    assert isinstance(tests.primary, EffectResult)
    assert tests.primary.name == MODEL
    assert len(tests.primary.participants) == cells.n + 1 == 12


def starts(trials: pd.DataFrame) -> dict[str, tuple[str, ...]]:
    """Return the order of each participant."""
    first = trials[trials["block"] == 1].drop_duplicates("participant")
    pairs = zip(first["participant"], first["condition"], strict=True)
    return {who: LEVELS if start == LEVELS[0] else LEVELS[::-1] for who, start in pairs}


def test_robustness_has_every_part(trials: pd.DataFrame) -> None:
    """With a bound in the protocol nothing is refused on a whole study."""
    cells = cell_means(trials, "team_reward", LEVELS)
    found = robustness(cells, rm_anova(cells), 5.0)
    assert found is not None
    assert found.refusals == ()
    assert isinstance(order_tests(cells, starts(trials), rm_anova(cells)), Crossover)


def test_equivalence_without_a_bound_is_refused(trials: pd.DataFrame) -> None:
    """A bound chosen after seeing the data would be no test."""
    cells = cell_means(trials, "team_reward", LEVELS)
    found = robustness(cells, rm_anova(cells), None)
    assert found is not None
    (refusal,) = found.refusals
    assert "states no bound" in refusal.reason


def test_robustness_needs_two_conditions(trials: pd.DataFrame) -> None:
    """With one there is no difference to look at."""
    cells = cell_means(trials, "team_reward", LEVELS[:1])
    assert robustness(cells, rm_anova(cells), None) is None
    assert order_tests(cells, {}, rm_anova(cells)) is None


def test_three_conditions_are_tested_as_latin_squares() -> None:
    """Williams' six orders of three conditions, twice: balanced, each term has its test."""
    levels = ("manual", "suggested", "assisted")
    runs = [*itertools.permutations(levels)] * 2
    people = tuple(f"P{place:02d}" for place in range(len(runs)))
    means = np.random.default_rng(3).normal(50, 5, (len(runs), 3))
    cells = Cells(people, levels, means, np.full(means.shape, 8))
    found = order_tests(cells, dict(zip(people, runs, strict=True)), rm_anova(cells))
    assert isinstance(found, LatinSquare)
    assert found.balanced
    assert all(isinstance(outcome, EffectResult) for outcome in found.outcomes)


def test_the_report_states_the_bound_or_its_absence(
    study: StudyRecordings, results: StudyResults
) -> None:
    """Without a bound the refusal stands in the report; with one, the test against it."""
    assert "The protocol states no bound" in render_report(results)
    protocol = {**study.first.protocol, "analysis": {"equivalence_bound": 30}}
    first = dataclasses.replace(study.first, protocol=protocol)
    bounded = dataclasses.replace(study, sessions=(first, *study.sessions[1:]))
    page = render_report(compute_results(bounded, StudyTables(bounded)))
    assert "within 30.00 points" in page
    assert "The protocol states no bound" not in page
