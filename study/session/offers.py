"""The correction round's allocation: the scorer chooses, then a few robots are offered, in turn."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from study.events.codes import ChoiceFlag, ChoiceSource
from study.protocol import Protocol
from study.seeding import stream_seed
from study.session.allocation import (
    AnyAllocation,
    Available,
    ManualAllocation,
    best_robot,
    make_allocation,
)
from study.session.plan import TrialPlan

Order = Callable[[int, int], int]
"""Number of the offer and robot to that robot's place in the draw."""


class OfferAllocation(ManualAllocation):
    """For a dwell the scorer's robot is operated; then the operator chooses among a few drawn.

    So the fleet goes where the scorer leads it, and the choices, made afresh at each offer, are
    about the states that it visits. Source: data aggregation (Ross, Gordon and Bagnell, AISTATS
    2011), with choices as labels.

    Args:
        robots: n.
        dwell: timesteps for which the scorer's robot is operated.
        offer_timesteps: timesteps for which robots are offered.
        offered: how many.
        order: draws robots.

    Attributes:
        offering: whether the operator chooses now.
    """

    def __init__(
        self, robots: int, dwell: int, offer_timesteps: int, offered: int, order: Order
    ) -> None:
        super().__init__(robots)
        self._dwell = dwell
        self._offer_timesteps = offer_timesteps
        self._count = offered
        self._order = order
        self._left = 0
        self._offers = 0
        self._offered: tuple[int, ...] = ()
        self._began = False
        self.offering = False
        self.source = ChoiceSource.SCORER

    @property
    def offered(self) -> tuple[int, ...]:
        """Return the robots offered now, in order; empty while the scorer chooses."""
        return self._offered if self.offering else ()

    def renew(self, scores: npt.NDArray[np.float64], available: Available) -> str:
        """Go on to the next stretch if it is time, and let the scorer choose where it does.

        Returns:
            Why the operated robot changed: "start", "dwell", "ended" or "offer"; "" if it did
            not.
        """
        if self.offering and self._left > 0:
            return ""
        ended = self.operated >= 0 and not available[self.operated]
        if self._began and not self.offering and self._left <= 0:
            return self._offer(available)
        if self._began and not self.offering and not ended:
            return ""
        chosen = best_robot(scores, available)
        if chosen < 0:
            return ""
        cause = "ended" if self._began and not self.offering else "dwell"
        cause = cause if self._began else "start"
        if not self._began or self.offering:
            self._left = self._dwell
        self._began, self.offering = True, False
        self.source = ChoiceSource.SCORER
        self._cycling_left = 0
        if chosen == self.operated:
            return ""
        self.operated = chosen
        return cause

    def _offer(self, available: Available) -> str:
        """Draw robots among those available; with fewer than two there is nothing to choose."""
        robots = np.flatnonzero(available).tolist()
        if len(robots) < 2:
            return ""
        self._offers += 1
        drawn = sorted(robots, key=lambda robot: (self._order(self._offers, robot), robot))
        self._offered = tuple(sorted(drawn[: self._count]))
        self._left = self._offer_timesteps
        self.offering = True
        self.source = ChoiceSource.OPERATOR
        self._cycling_left = 0
        before, self.operated = self.operated, -1
        return "offer" if before >= 0 else ""

    def can_be_chosen(self, available: Available) -> Available:
        """Return which robots can be chosen now: those offered, bool [n]."""
        if not self.offering:
            return available
        offered = np.zeros_like(available)
        offered[list(self._offered)] = True
        return available & offered

    def select(self, robot: int) -> int:
        """Choose a robot that is offered; any other does nothing."""
        return super().select(robot) if robot in self.offered else -1

    def select_next(self) -> int:
        """Choose the next robot among those offered."""
        if not self.offered:
            return -1
        later = [robot for robot in self.offered if robot > self.operated]
        switched = self.select(later[0] if later else self.offered[0])
        self._settle_later()
        return switched

    def flag(self) -> ChoiceFlag:
        """Return whether the row of this timestep may be fitted, if it is the operator's."""
        return super().flag() if self.offering else ChoiceFlag.USABLE

    def timestep_done(self, *, driven: bool) -> None:
        """Count down to the next stretch."""
        super().timestep_done(driven=driven)
        self._left -= 1

    def part_left(self) -> float:
        """Return the fraction of the scorer's dwell that is left, 1 to 0; -1 in an offer."""
        return -1.0 if self.offering else max(0, self._left) / self._dwell


def trial_allocation(plan: TrialPlan, protocol: Protocol, seed: int) -> AnyAllocation:
    """Return the allocation of a trial.

    Args:
        plan: of the trial.
        protocol: the study.
        seed: the session's.
    """
    part = protocol.correction_round
    if plan.allocation != "correction_round" or part is None:
        return make_allocation(plan.allocation, plan.robots, plan.dwell)
    return OfferAllocation(
        plan.robots,
        plan.dwell,
        part.offer_timesteps,
        part.offered,
        # Ranks of keyed numbers: the same draw with any version of any library.
        lambda offer, robot: stream_seed(seed, "offer", *plan.starts_key, offer, robot),
    )
