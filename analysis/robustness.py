"""Whether the result on team reward hangs on a choice of ours: other tests, people, orders."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import pandas as pd

from analysis.statistics.bayes_factor import BayesFactor, paired_bayes_factor
from analysis.statistics.cells import Cells
from analysis.statistics.crossover import Crossover, crossover
from analysis.statistics.leave_one_out import LeaveOneOut, leave_one_out
from analysis.statistics.normality import shapiro_wilk
from analysis.statistics.permutation import sign_flip
from analysis.statistics.result import Check, EffectResult, Outcome, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.trial_model import trial_model
from analysis.statistics.wilcoxon import signed_rank


@dataclasses.dataclass(frozen=True, slots=True)
class RewardTests:
    """The tests of the condition effect on team reward.

    Attributes:
        primary: of the participants' means, or of the trials where somebody lacks some.
        sensitivity: other tests of the same question.
    """

    primary: Outcome
    sensitivity: tuple[Outcome, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class Robustness:
    """What else was looked at, with two conditions.

    Attributes:
        orders: condition adjusted for period, period, carry-over.
        left_out: the paired test without each participant in turn.
        bayes: the Bayes factor of a difference against none.
        normality: of the participants' differences.
    """

    orders: Crossover | Refusal
    left_out: LeaveOneOut | Refusal
    bayes: BayesFactor | Refusal
    normality: Check | Refusal

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """What was not computed, each reason once."""
        found = (self.orders, self.left_out, self.bayes, self.normality)
        unique: dict[str, Refusal] = {}
        for outcome in found:
            if isinstance(outcome, Refusal):
                unique.setdefault(outcome.reason, outcome)
        return tuple(unique.values())


def reward_tests(trials: pd.DataFrame, cells: Cells, complete: frozenset[str]) -> RewardTests:
    """Test the condition effect on team reward.

    The test of the participants' means is primary if all have as many trials under each condition.
    Else means of unlike precision would count alike, and who lacks a condition would not count;
    the model of the trials then takes its place.

    Args:
        trials: rows that enter, of any participant with a trial under a condition compared.
        cells: participants' means; of those with trials under every condition.
        complete: participants whose sessions ran to their end.
    """
    period = trials["block"].astype("int64")
    levels = cells.levels
    model = trial_model(trials.assign(period=period), levels)
    means = rm_anova(cells)
    by_trial = model if isinstance(model, Refusal) else _named(model.test("condition"))
    others: list[Outcome] = []
    if _trials_missing(trials, cells) and isinstance(by_trial, EffectResult):
        primary: Outcome = dataclasses.replace(by_trial, role="primary")
        if isinstance(means, EffectResult):
            others.append(dataclasses.replace(means, role="sensitivity"))
        else:
            others.append(means)
    else:
        primary = means
        if isinstance(primary, EffectResult):
            others.append(by_trial)
    if not isinstance(model, Refusal):
        others.append(_named(model.satterthwaite[0]))
    if isinstance(means, EffectResult):
        others += _beside_means(cells, complete)
    return RewardTests(primary, tuple(others))


def robustness(cells: Cells, orders: Mapping[str, tuple[str, ...]]) -> Robustness | None:
    """Look at the paired difference from other sides; None unless two conditions have data."""
    if len(cells.levels) != 2 or isinstance(rm_anova(cells), Refusal):
        return None
    return Robustness(
        orders=crossover(cells, orders),
        left_out=leave_one_out(cells),
        bayes=paired_bayes_factor(cells),
        normality=shapiro_wilk(cells),
    )


def _beside_means(cells: Cells, complete: frozenset[str]) -> list[Outcome]:
    """Return the tests without assumptions of distribution, and that of complete sessions."""
    outcomes: list[Outcome] = []
    if len(cells.levels) == 2:
        differences = cells.means[:, 1] - cells.means[:, 0]
        outcomes += [signed_rank(differences, cells.participants), sign_flip(cells)]
    kept = [place for place, who in enumerate(cells.participants) if who in complete]
    if len(kept) < cells.n:
        name = "Participant means, complete sessions only"
        outcomes.append(rm_anova(cells.only(kept), name, "sensitivity"))
    return outcomes


def _named(result: EffectResult) -> EffectResult:
    return dataclasses.replace(result, name=f"Mixed model of trials, {result.method}")


def _trials_missing(trials: pd.DataFrame, cells: Cells) -> bool:
    """Return whether somebody has fewer trials under a condition than others, or none."""
    unlike = cells.counts.size > 0 and bool(cells.counts.max() > cells.counts.min())
    return unlike or not set(trials["participant"].astype(str)) <= set(cells.participants)
