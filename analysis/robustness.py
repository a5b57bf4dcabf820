"""Whether the result on team reward hangs on a choice of ours: other tests, people, orders."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import pandas as pd

from analysis.statistics.bayes_factor import BayesFactor, paired_bayes_factor
from analysis.statistics.cells import Cells
from analysis.statistics.contrasts import paired_contrasts
from analysis.statistics.crossover import Crossover, crossover
from analysis.statistics.equivalence import equivalence
from analysis.statistics.friedman import friedman
from analysis.statistics.latin_square import LatinSquare, latin_square
from analysis.statistics.leave_one_out import LeaveOneOut, leave_one_out
from analysis.statistics.mixed.model import MixedModel
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
        means: the test of the participants' means, primary or not.
        contrasts: each pair of three or more conditions, Holm-adjusted: of the means, or of the
            trials where these are primary.
    """

    primary: Outcome
    sensitivity: tuple[Outcome, ...]
    means: Outcome
    contrasts: tuple[Outcome, ...] = ()


@dataclasses.dataclass(frozen=True, slots=True)
class Robustness:
    """What else was looked at, with two conditions.

    Attributes:
        left_out: the paired test without each participant in turn.
        bayes: the Bayes factor of a difference against none.
        normality: of the participants' differences.
        equivalence: of the conditions, within the bound that the protocol states.
    """

    left_out: LeaveOneOut | Refusal
    bayes: BayesFactor | Refusal
    normality: Check | Refusal
    equivalence: Outcome

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """What was not computed, each reason once."""
        found = (self.left_out, self.bayes, self.normality, self.equivalence)
        unique: dict[str, Refusal] = {}
        for outcome in found:
            if isinstance(outcome, Refusal):
                unique.setdefault(outcome.reason, outcome)
        return tuple(unique.values())


def reward_tests(trials: pd.DataFrame, cells: Cells) -> RewardTests:
    """Test the condition effect on team reward.

    The test of the participants' means is primary if all have as many trials under each condition.
    Else means of unlike precision would count alike, and who lacks a condition would not count;
    the model of the trials then takes its place.

    Args:
        trials: rows that enter, of any participant with a trial under a condition compared.
        cells: participants' means; of those with trials under every condition.
    """
    levels = cells.levels
    model = model_of_trials(trials, levels)
    several = len(levels) > 2
    means = means_test(cells)
    by_trial = model if isinstance(model, Refusal) else _named(model.test("condition"))
    others: list[Outcome] = []
    if trials_missing(trials, cells) and isinstance(by_trial, EffectResult):
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
        others += _beside_means(cells)
    pairs: tuple[Outcome, ...] = ()
    if several and isinstance(primary, EffectResult):
        pairs = paired_contrasts(cells)
        if primary.method == "Kenward-Roger" and not isinstance(model, Refusal):
            pairs = tuple(_pair(test) for test in model.contrasts)
    return RewardTests(primary, tuple(others), means, pairs)


def primary_test(trials: pd.DataFrame, cells: Cells) -> Outcome:
    """Return the primary test alone, the one of `reward_tests`, without computing the others.

    Args:
        trials: as for `reward_tests`.
        cells: participants' means.
    """
    if trials_missing(trials, cells):
        model = model_of_trials(trials, cells.levels)
        if not isinstance(model, Refusal):
            return dataclasses.replace(_named(model.test("condition")), role="primary")
    return means_test(cells)


def means_test(cells: Cells) -> Outcome:
    """Test the participants' means."""
    several = len(cells.levels) > 2
    return rm_anova(cells, "Participant means (RM-ANOVA)") if several else rm_anova(cells)


def model_of_trials(trials: pd.DataFrame, levels: Sequence[str]) -> MixedModel | Refusal:
    """Fit the model of the trials; the place of a block in the session is its period."""
    return trial_model(trials.assign(period=trials["block"].astype("int64")), levels)


def trials_missing(trials: pd.DataFrame, cells: Cells) -> bool:
    """Return whether somebody has fewer trials under a condition than others, or none."""
    unlike = cells.counts.size > 0 and bool(cells.counts.max() > cells.counts.min())
    return unlike or not set(trials["participant"].astype(str)) <= set(cells.participants)


def robustness(cells: Cells, means: Outcome, bound: float | None) -> Robustness | None:
    """Look at the paired difference from other sides; None unless two conditions have data.

    Args:
        cells: participants' means.
        means: the test of these means: where it is refused, so is the rest.
        bound: the smallest difference that would matter, points; None if the protocol has none.
    """
    if len(cells.levels) != 2 or isinstance(means, Refusal):
        return None
    return Robustness(
        left_out=leave_one_out(cells),
        bayes=paired_bayes_factor(cells),
        normality=shapiro_wilk(cells),
        equivalence=equivalence(cells, bound),
    )


def order_tests(
    cells: Cells, orders: Mapping[str, tuple[str, ...]], means: Outcome
) -> Crossover | LatinSquare | Refusal | None:
    """Test condition, period and carry-over of AB/BA or of Latin squares; None without a test.

    Args:
        cells: participants' means.
        orders: each participant's conditions in the order run.
        means: the test of these means: where it is refused, so are these.
    """
    if isinstance(means, Refusal):
        return None
    return crossover(cells, orders) if len(cells.levels) == 2 else latin_square(cells, orders)


def _beside_means(cells: Cells) -> list[Outcome]:
    """Return the tests without assumptions of distribution, of two conditions."""
    if len(cells.levels) != 2:
        return [friedman(cells)]
    differences = cells.means[:, 1] - cells.means[:, 0]
    return [signed_rank(differences, cells.participants), sign_flip(cells)]


def _pair(test: EffectResult) -> EffectResult:
    return dataclasses.replace(test, name=test.name.split(": ", 1)[-1])


def _named(result: EffectResult) -> EffectResult:
    return dataclasses.replace(result, name=f"Mixed model of trials, {result.method}")
