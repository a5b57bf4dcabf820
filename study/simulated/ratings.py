"""How an operator rates a block: a crude model, from what it saw and did.

Ease falls with the choices it had to make, with robots that it saw in need and left
alone, and with time spent reorienting. Success is the share of goals among the endings
that it saw; once the points are shown, it is where an average trial's points lie on the
scale shown, against the operator's aspiration. Both get a personal shift and noise. The
model knows no condition by name; it claims no more than that ratings hang on experience.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from study.screens import RevealScreen, SurveyItem, Tile
from study.simulated.parameters import OperatorParameters

_PRIOR_ENDINGS = 2.0


@dataclasses.dataclass(slots=True)
class Experience:
    """What an operator went through since its last block.

    Attributes:
        driven_ns: time before a fleet.
        reorienting_ns: time of that in which it was finding its way in after a switch.
        choices: robots that it chose.
        looks: robots that it looked at beside its own.
        unmet: those of them in need.
        goals, losses: endings that it saw.
        revealed: 0 to 1, place of an average trial's points on the scale shown, or None
            before that.
    """

    driven_ns: int = 0
    reorienting_ns: int = 0
    choices: int = 0
    looks: int = 0
    unmet: int = 0
    goals: int = 0
    losses: int = 0
    revealed: float | None = None
    _endings: set[tuple[int, int]] = dataclasses.field(default_factory=set)

    def see_ending(self, tile: Tile) -> None:
        """Count a goal or a loss, once, if the tile shows one."""
        cue = tile.cue
        if cue is None or cue.kind not in {"goal", "lost"}:
            return
        ending = (tile.robot, cue.since_ns)
        if ending in self._endings:
            return
        self._endings.add(ending)
        if cue.kind == "goal":
            self.goals += 1
        else:
            self.losses += 1

    def see_reveal(self, screen: RevealScreen) -> None:
        """Take in the points of the block."""
        span = screen.scale_high - screen.scale_low
        average = screen.total / max(1, len(screen.trial_rewards))
        place = (average - screen.scale_low) / span if span > 0.0 else 0.5
        self.revealed = min(1.0, max(0.0, place))


class Rater:
    """Answers the items of a survey."""

    def __init__(self, parameters: OperatorParameters, random: np.random.Generator) -> None:
        self._parameters = parameters
        self._random = random

    def answer(self, item: SurveyItem, experience: Experience) -> int:
        """Return the answer to an item, within its scale.

        The item is understood from its words: ease, success, or neither, which gets the
        middle of the scale.
        """
        words = item.text.lower()
        middle = 0.5 * (item.low + item.high)
        if "success" in words:
            level = self._success(experience)
        elif "easy" in words or "ease" in words.split():
            level = self._ease(experience)
        else:
            level = 4.0
        noise = self._parameters.response_noise * float(self._random.standard_normal())
        # The model speaks in points of a scale from 1 to 7; other scales are stretched.
        stretch = (item.high - item.low) / 6.0
        value = middle + (level - 4.0 + self._parameters.response_shift + noise) * stretch
        return min(item.high, max(item.low, round(value)))

    def _ease(self, experience: Experience) -> float:
        parameters = self._parameters
        driven_ns = max(1, experience.driven_ns)
        per_minute = experience.choices * 60e9 / driven_ns
        unmet = experience.unmet / max(1, experience.looks)
        return (
            parameters.ease_level
            - parameters.ease_switch_cost * per_minute
            - parameters.ease_unmet_cost * unmet
            - parameters.ease_waiting_cost * experience.reorienting_ns / driven_ns
        )

    def _success(self, experience: Experience) -> float:
        if experience.revealed is not None:
            achieved = experience.revealed - self._parameters.aspiration
        else:
            endings = experience.goals + experience.losses + _PRIOR_ENDINGS
            achieved = (experience.goals + 0.5 * _PRIOR_ENDINGS) / endings - 0.5
        return 4.0 + self._parameters.success_gain * achieved
