"""Who is operated: the operator's choice, with or without a suggestion, or the scorer's."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.codes import ChoiceFlag, ChoiceSource

Available = npt.NDArray[np.bool_]
SETTLE_TIMESTEPS = 4
"""A robot reached by Tab counts as chosen once it is driven or kept this long."""


def best_robot(scores: npt.NDArray[np.float64], available: Available) -> int:
    """Return the available robot with the highest score, ties to the lower index; -1 if none.

    A score that is not a number never wins. Without scores all robots tie.
    """
    if not available.any():
        return -1
    candidates = np.flatnonzero(available & ~np.isnan(scores) if scores.size else available)
    if not scores.size or not candidates.size:
        return int(np.argmax(available))
    return int(candidates[np.argmax(scores[candidates])])


class FixedAllocation:
    """One robot, operated throughout."""

    source = ChoiceSource.NONE

    def __init__(self, operated: int) -> None:
        self.operated = operated

    def flag(self) -> ChoiceFlag:
        """Return why the row is no choice."""
        return ChoiceFlag.NO_CHOICE

    def timestep_done(self, *, driven: bool) -> None:
        """Nothing changes."""


class ManualAllocation:
    """The operator chooses; nobody is operated before the first selection."""

    def __init__(self, robots: int) -> None:
        self._robots = robots
        self._cycling_left = 0
        self.operated = -1
        self.source = ChoiceSource.OPERATOR

    def select(self, robot: int) -> int:
        """Choose a robot directly.

        Returns:
            The robot, if this is a switch; -1 if it was operated already or is none.
        """
        if not 0 <= robot < self._robots:
            return -1
        self._cycling_left = 0
        if robot == self.operated:
            return -1
        self.operated = robot
        return robot

    def select_next(self) -> int:
        """Choose the next robot by number: passing one on the way is not choosing it."""
        switched = self.select((self.operated + 1) % self._robots)
        self._settle_later()
        return switched

    def _settle_later(self) -> None:
        self._cycling_left = SETTLE_TIMESTEPS

    def flag(self) -> ChoiceFlag:
        """Return whether the row of this timestep may be fitted."""
        if self.operated < 0:
            return ChoiceFlag.BEFORE_FIRST_SELECTION
        return ChoiceFlag.CYCLING if self._cycling_left > 0 else ChoiceFlag.USABLE

    def timestep_done(self, *, driven: bool) -> None:
        """Count down to settling; driving settles at once."""
        self._cycling_left = 0 if driven else max(0, self._cycling_left - 1)


class SuggestedAllocation(ManualAllocation):
    """The operator chooses; the robot that the scorer would choose is suggested, one key accepts.

    Source: paper, section on the pilot's interface: the argmax robot is highlighted.

    Args:
        robots: n.
        dwell: timesteps for which a suggestion stays unless its robot ends; 0 renews it at
            every timestep.
    """

    def __init__(self, robots: int, dwell: int) -> None:
        super().__init__(robots)
        self._dwell = max(1, dwell)
        self._suggestion_left = 0
        self.suggested = -1

    def renew(self, scores: npt.NDArray[np.float64], available: Available) -> None:
        """Suggest anew if it is time. Without scores nothing is suggested."""
        ended = self.suggested >= 0 and not available[self.suggested]
        if self._suggestion_left > 0 and not ended:
            return
        self._suggestion_left = self._dwell
        self.suggested = best_robot(scores, available) if scores.size else -1

    def select(self, robot: int) -> int:
        """Choose a robot directly: the operator's choice, whatever is suggested."""
        switched = super().select(robot)
        if switched >= 0:
            self.source = ChoiceSource.OPERATOR
        return switched

    def accept(self) -> int:
        """Choose the suggested robot; return it if this is a switch, else -1."""
        switched = self.select(self.suggested)
        if switched >= 0:
            self.source = ChoiceSource.ACCEPTED_SUGGESTION
        return switched

    def timestep_done(self, *, driven: bool) -> None:
        """Count down to settling and to the next suggestion."""
        super().timestep_done(driven=driven)
        self._suggestion_left -= 1


class AssistedAllocation:
    """The scorer chooses, every ``dwell`` timesteps and when the operated robot ends.

    Source: paper, section on the user study: "every 15 timesteps".

    Attributes:
        operated: the operated robot; -1 before the first choice.
        scored: whether there are scores. Without, as where the scorer could not be fitted, the
            first available robot is operated, and no switch is announced.
    """

    def __init__(self, dwell: int) -> None:
        self._dwell = dwell
        self._left = 0
        self.scored = True
        self.operated = -1
        self.source = ChoiceSource.SCORER

    def rechoose(self, scores: npt.NDArray[np.float64], available: Available) -> str:
        """Choose anew if it is time.

        Returns:
            Why the operated robot changed: "start", "dwell", "ended", or "" if it did not.
        """
        self.scored = bool(scores.size)
        ended = self.operated >= 0 and not available[self.operated]
        if self._left > 0 and not ended:
            return ""
        cause = "start" if self.operated < 0 else "ended" if ended else "dwell"
        chosen = best_robot(scores, available)
        if chosen < 0:
            return ""
        self._left = self._dwell
        if chosen == self.operated:
            return ""
        self.operated = chosen
        return cause

    def flag(self) -> ChoiceFlag:
        """Every row is a choice of the scorer's."""
        return ChoiceFlag.USABLE

    def timestep_done(self, *, driven: bool) -> None:  # noqa: ARG002 - the operator does not matter
        """Count down to the next switch."""
        self._left -= 1

    def timesteps_left(self) -> int:
        """Return the timesteps until the scorer chooses anew."""
        return max(0, self._left)

    def dwell_left(self) -> float:
        """Return the fraction of the dwell that is left, 1 to 0; -1 without scores."""
        return max(0, self._left) / self._dwell if self.scored else -1.0


AnyAllocation = FixedAllocation | ManualAllocation | SuggestedAllocation | AssistedAllocation


def make_allocation(allocation: str, robots: int, dwell: int) -> AnyAllocation:
    """Return the allocation of a trial.

    Args:
        allocation: "correction", "manual", "suggested", "assisted" or "none".
        robots: n; with one robot there is nothing to choose.
        dwell: timesteps between automatic switches, or for which a suggestion stays.
    """
    if allocation == "none":
        return FixedAllocation(-1)
    if robots == 1:
        return FixedAllocation(0)
    if allocation == "assisted":
        return AssistedAllocation(dwell)
    if allocation == "suggested":
        return SuggestedAllocation(robots, dwell)
    return ManualAllocation(robots)
