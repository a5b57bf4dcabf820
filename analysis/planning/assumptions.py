"""What a plan takes for true: effects, scatter, order effects, what is lost, how it is tested."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from study.errors import StudyError

Order = tuple[int, ...]
MOST_PARTICIPANTS, MOST_TRIALS = 1000, 200
MOST_POINTS = 1e9
CLEAREST = 1000.0
"""Largest difference of effects that is planned for, in standard deviations of trials."""


@dataclasses.dataclass(frozen=True, slots=True)
class Assumptions:
    """The law of made-up studies, in points of team reward a trial.

    A trial's reward is the participant's level, the effect of the condition for this participant,
    what order and practice add, and noise. All scatter is normal.

    Attributes:
        effects: of each condition less the reference; the first is the reference's, 0.
        effect_sd: standard deviation between participants of the true difference of any two
            conditions.
        trial_sd: standard deviation of one participant's trials under one condition.
        orders: places of the conditions, given out in turn: each a permutation of their numbers.
        level_sd: standard deviation between participants of their level.
        period: by which each later block exceeds the one before.
        learning: by which each trial exceeds the one before within its block.
        carry_over: by which a block after one of another condition than the reference differs.
        drop_out: part of the participants who leave, at any trial with equal chance.
        missing: part of the trials that are lost one by one.
        needed: part of all trials that a participant must have to be analysed; 0 for no such rule.
        alpha: below this p a test finds something.
    """

    effects: tuple[float, ...]
    effect_sd: float
    trial_sd: float
    orders: tuple[Order, ...]
    level_sd: float = 0.0
    period: float = 0.0
    learning: float = 0.0
    carry_over: float = 0.0
    drop_out: float = 0.0
    missing: float = 0.0
    needed: float = 0.0
    alpha: float = 0.05

    @property
    def conditions(self) -> int:
        """How many conditions are compared."""
        return len(self.effects)

    @property
    def always_means(self) -> bool:
        """Whether all who are analysed have all their trials: the test is then that of means."""
        return self.needed >= 1.0 or (self.drop_out == 0 and self.missing == 0)

    def trials_needed(self, trials: int) -> int:
        """Return how many trials in all a participant must have, of so many a condition."""
        return math.ceil(self.needed * self.conditions * trials - 1e-9)

    def difference_variance(self, trials: int) -> float:
        """Return the variance of one participant's difference of two conditions' means."""
        return self.effect_sd**2 + 2 * self.trial_sd**2 / trials

    def shifts(self) -> npt.NDArray[np.float64]:
        """Return what order adds to each condition: shape (orders, conditions)."""
        found = np.zeros((len(self.orders), self.conditions))
        for row, order in enumerate(self.orders):
            for place, condition in enumerate(order):
                found[row, condition] = self.period * place
                if place and order[place - 1] != 0:
                    found[row, condition] += self.carry_over
        return found


@dataclasses.dataclass(frozen=True, slots=True, order=True)
class Design:
    """One size of a study: smaller is fewer participants, and then fewer trials.

    Attributes:
        participants: how many begin.
        trials: how many each runs under each condition.
    """

    participants: int
    trials: int


def check(assumptions: Assumptions) -> None:
    """Refuse what no study can be.

    Raises:
        StudyError: names the option and what it may be.
    """
    for problem in _problems(assumptions):
        raise StudyError(problem, "Give another value.")


def check_grid(designs: tuple[Design, ...]) -> None:
    """Refuse sizes that no test can be made of.

    Raises:
        StudyError: names the size.
    """
    for design in designs:
        if not 3 <= design.participants <= MOST_PARTICIPANTS:
            raise StudyError(
                f"--participants: {design.participants} given",
                f"A test needs at least 3; at most {MOST_PARTICIPANTS} are planned for.",
            )
        if not 1 <= design.trials <= MOST_TRIALS:
            raise StudyError(
                f"--trials: {design.trials} given", f"Give 1 to {MOST_TRIALS} a condition."
            )


def _problems(given: Assumptions) -> Iterator[str]:
    numbers = {
        "--effect-sd": given.effect_sd,
        "--trial-sd": given.trial_sd,
        "--level-sd": given.level_sd,
        "--period": given.period,
        "--learning": given.learning,
        "--carry-over": given.carry_over,
        **{f"--effect (condition {at})": value for at, value in enumerate(given.effects)},
    }
    for name, value in numbers.items():
        if not math.isfinite(value):
            yield f"{name}: {value} is not a finite number"
        elif abs(value) > MOST_POINTS:
            yield f"{name}: {value:g} given; at most {MOST_POINTS:g} points"
    for name in ("--effect-sd", "--level-sd"):
        if numbers[name] < 0:
            yield f"{name}: {numbers[name]:g} given; a standard deviation is 0 or more"
    if given.trial_sd <= 0:
        yield f"--trial-sd: {given.trial_sd:g} given; trials scatter, so it is above 0"
    for name, share in (("--drop-out", given.drop_out), ("--missing", given.missing)):
        if not 0 <= share < 1:
            yield f"{name}: {share:g} given; a part of the whole is 0 or more and below 1"
    if not 0 < given.alpha < 1:
        yield f"--alpha: {given.alpha:g} given; it lies between 0 and 1"
    spread = max(given.effects, default=0.0) - min(given.effects, default=0.0)
    if 0 < given.trial_sd <= MOST_POINTS and spread > CLEAREST * given.trial_sd:
        yield (
            f"--effect: {spread:g} points are over {CLEAREST:g} times what trials scatter "
            f"({given.trial_sd:g}): nothing has to be planned to find that"
        )
    if given.conditions < 2:
        yield "the protocol has one condition; a plan compares two or more"
