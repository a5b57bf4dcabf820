"""What a stage is: entered once, fed with inputs, done when it says so."""

from __future__ import annotations

from typing import Protocol

from study.events.inputs import Input
from study.screens import Screen, WaitScreen
from study.session.context import Context, Outbox


class Stage(Protocol):
    """One step of the session.

    A stage puts events and effects into the outbox; the session shows its screen.
    """

    kind: str

    def enter(self, t_ns: int, out: Outbox) -> bool:
        """Begin; return True if there is nothing to do."""
        ...

    def handle(self, given: Input, out: Outbox) -> bool:
        """Take in one input; return True when the stage is done."""
        ...

    def pause(self, out: Outbox) -> None:
        """Stand still until `resume`."""
        ...

    def resume(self, t_ns: int, out: Outbox) -> None:
        """Go on."""
        ...

    def break_off(self, t_ns: int, out: Outbox) -> None:
        """End early: close what is open in the events."""
        ...

    def screen(self) -> Screen:
        """Return what is to be seen now."""
        ...


class QuietStage:
    """A stage that pausing and breaking off leave as it is."""

    def pause(self, out: Outbox) -> None:
        """Nothing moves."""

    def resume(self, t_ns: int, out: Outbox) -> None:
        """Nothing moved."""

    def break_off(self, t_ns: int, out: Outbox) -> None:
        """Nothing is open."""


class PassingStage(QuietStage):
    """A stage that is over as soon as it is entered: nothing reaches it, nobody sees it."""

    def __init__(self, context: Context) -> None:
        self._context = context

    def handle(self, given: Input, out: Outbox) -> bool:  # noqa: ARG002 - stages are fed alike
        """Nothing reaches it."""
        return True

    def screen(self) -> Screen:
        """Return nothing worth seeing."""
        return WaitScreen(title=self._context.say("One moment"), text="", progress=-1.0)
