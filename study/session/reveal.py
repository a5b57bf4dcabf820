"""The reveal stage: the reward of the block, which was hidden until now."""

from __future__ import annotations

import math

from study.events.events import RewardRevealed
from study.events.inputs import Input, KeyChanged, PointerPressed
from study.screens import RevealScreen, Screen
from study.session.context import Context, Outbox
from study.session.page_texts import block_finished
from study.session.plan import RevealPlan
from study.session.stage import QuietStage


class RevealStage(QuietStage):
    """Shows every trial's points and their sum."""

    kind = "reveal"

    def __init__(self, plan: RevealPlan, context: Context) -> None:
        self._plan = plan
        self._context = context
        self._rewards = context.knowledge.block_rewards.get(plan.place.condition, [])
        self._total = _sum(self._rewards)

    def enter(self, t_ns: int, out: Outbox) -> bool:
        """Record what is shown."""
        place = self._plan.place
        out.events.append(
            RewardRevealed(t_ns, place.phase, place.block, place.condition, self._total)
        )
        return False

    def handle(self, given: Input, out: Outbox) -> bool:  # noqa: ARG002 - nothing to send
        """Go on at Enter or at the button."""
        if isinstance(given, KeyChanged):
            return given.down and given.key == self._context.protocol.keys.confirm
        return isinstance(given, PointerPressed) and given.target == "confirm"

    def screen(self) -> Screen:
        """Return the bars, on the scale that every block of the session shares."""
        place = self._plan.place
        say = self._context.say
        low, high = self._scale()
        return RevealScreen(
            header_left=block_finished(self._context, place.block),
            header_right=say("Your points"),
            block=place.block,
            total=self._total,
            trial_rewards=tuple(self._rewards),
            robots=self._context.protocol.condition(place.condition).robots,
            scale_low=low,
            scale_high=high,
            next_hint=self._context.count(
                "Next: the same question again. Your first answer stays as it is.",
                "Next: the same questions again. Your first answers stay as they are.",
                self._asked_again(),
            )
            if self._plan.surveys_follow
            else "",
        )

    def _asked_again(self) -> int:
        """Return how many questions follow."""
        asked = self._context.questionnaires
        uses = self._context.protocol.questionnaires
        return sum(len(asked[use.name].items) for use in uses if "after_reveal" in use.when)

    def _scale(self) -> tuple[float, float]:
        """Fix the axis at the first reveal, with room above; later blocks widen it if they must."""
        finite = {
            condition: [reward for reward in rewards if math.isfinite(reward)]
            for condition, rewards in self._context.knowledge.block_rewards.items()
        }
        seen = [reward for rewards in finite.values() for reward in rewards]
        first = finite.get(self._context.order[0], [])
        step = _nice_step(max([1.0, *(1.5 * abs(reward) for reward in first)]) / 3)
        high = max(step * 3, step * math.ceil(max(0.0, *seen, 0.0) / step))
        low = min(0.0, step * math.floor(min(0.0, *seen, 0.0) / step))
        return low, high


def _sum(rewards: list[float]) -> float:
    """Add up exactly; what a faulty task made of NaN and infinities is no number."""
    return math.fsum(rewards) if all(map(math.isfinite, rewards)) else math.nan


def _nice_step(least: float) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that is not below ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(power * factor for factor in (1, 2, 5, 10) if power * factor >= least)
