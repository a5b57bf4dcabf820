"""Which test of team reward is primary, and what stands beside it."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from analysis.robustness import reward_tests, robustness
from analysis.statistics.cells import cell_means
from analysis.statistics.crossover import Crossover
from analysis.statistics.result import EffectResult
from analysis.statistics.rm_anova import rm_anova

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


def test_robustness_has_every_part(trials: pd.DataFrame) -> None:
    """On a whole study nothing is refused."""
    cells = cell_means(trials, "team_reward", LEVELS)
    first = trials[trials["block"] == 1].drop_duplicates("participant")
    starts = dict(zip(first["participant"], first["condition"], strict=True))
    orders = {who: LEVELS if start == LEVELS[0] else LEVELS[::-1] for who, start in starts.items()}
    found = robustness(cells, orders, rm_anova(cells))
    assert found is not None
    assert found.refusals == ()
    assert isinstance(found.orders, Crossover)


def test_robustness_needs_two_conditions(trials: pd.DataFrame) -> None:
    """With one there is no difference to look at."""
    cells = cell_means(trials, "team_reward", LEVELS[:1])
    assert robustness(cells, {}, rm_anova(cells)) is None
