"""The break stage: a rest with a timer; Enter goes on once the shortest rest is over."""

from __future__ import annotations

from study.events.inputs import Input, KeyChanged, PointerPressed, TimestepDue
from study.screens import BreakScreen, Screen
from study.seat_settings import BreakPart
from study.session.context import Context, Outbox
from study.session.effects import SetPace, Show
from study.session.plan import BreakPlan
from study.session.stage import QuietStage


class BreakStage(QuietStage):
    """Counts down by the clock's ticks, one a second."""

    kind = "break"

    def __init__(self, plan: BreakPlan, context: Context) -> None:
        self._plan = plan
        self._context = context
        assert context.protocol.breaks is not None  # noqa: S101 - planned only with breaks
        self._settings: BreakPart = context.protocol.breaks
        self._rested = 0

    def enter(self, t_ns: int, out: Outbox) -> bool:  # noqa: ARG002 - stages are entered alike
        """Start the timer."""
        out.effects.append(SetPace(1.0))
        return False

    def handle(self, given: Input, out: Outbox) -> bool:
        """Count seconds; go on at Enter or at the button when that is allowed."""
        if isinstance(given, TimestepDue):
            self._rested += 1
            if self._rested >= max(self._settings.seconds, self._settings.minimum_seconds):
                out.effects.append(SetPace(0.0))
            out.effects.append(Show(self.screen()))
            return False
        confirm = self._context.protocol.keys.confirm
        on = (isinstance(given, KeyChanged) and given.down and given.key == confirm) or (
            isinstance(given, PointerPressed) and given.target == "confirm"
        )
        if on and self._may_go_on():
            out.effects.append(SetPace(0.0))
            return True
        return False

    def _may_go_on(self) -> bool:
        return self._rested >= self._settings.minimum_seconds

    def pause(self, out: Outbox) -> None:
        """Stop the timer."""
        out.effects.append(SetPace(0.0))

    def resume(self, t_ns: int, out: Outbox) -> None:  # noqa: ARG002 - the timer counts ticks
        """Start the timer again."""
        if self._rested < max(self._settings.seconds, self._settings.minimum_seconds):
            out.effects.append(SetPace(1.0))

    def screen(self) -> Screen:
        """Return the timer."""
        settings = self._settings
        return BreakScreen(
            seconds_left=max(0, settings.seconds - self._rested),
            seconds_total=settings.seconds,
            wait_seconds=max(0, settings.minimum_seconds - self._rested),
        )
