"""The loop of a simulated participant: the same session in virtual time, without a window."""

from __future__ import annotations

from typing import Protocol

from study.errors import StudyError
from study.events.inputs import KeyChanged, TextTyped, TimestepDue
from study.screens import Screen, SurveyScreen
from study.shell.conductor import Conductor

SECOND = 1_000_000_000
TICK_NS = 100_000_000
STALLED_TICKS = 100_000
"""Ticks in a row without a timestep after which the operator is taken to be at a loss."""


class KeyStrokeLike(Protocol):
    """A key going down or up."""

    @property
    def key(self) -> str:
        """Name of the key."""
        ...

    @property
    def down(self) -> bool:
        """Whether it goes down."""
        ...


class Operator(Protocol):
    """What sits at the keys: it sees screens and nothing else."""

    def act(self, screen: Screen, now_ns: int) -> tuple[KeyStrokeLike, ...]:
        """Return the keys that go down or up now."""
        ...


class VirtualClock:
    """Time that goes on only when the loop says so."""

    def __init__(self) -> None:
        self.now_ns = 0

    def now(self) -> int:
        """Return the session's time, ns."""
        return self.now_ns


def run_virtual(conductor: Conductor, operator: Operator, clock: VirtualClock) -> None:
    """Run until the session is finished.

    One tick is one timestep while the robots move, a tenth of a second otherwise. An
    answer of fleet or fitter is waited for, so that slow answers skip no timestep.

    Raises:
        StudyError: the operator found no way on.
    """
    idle_ticks = 0
    while not conductor.finished:
        while _awaits(conductor) and not conductor.finished:
            conductor.collect(clock.now, wait_s=1.0)
        if conductor.finished:
            return
        pace = conductor.pace
        if pace.timesteps_per_second > 0 and not pace.unhurried:
            clock.now_ns += round(SECOND / pace.timesteps_per_second)
            conductor.feed(TimestepDue(clock.now_ns, late_ns=0))
            continue
        running = pace.timesteps_per_second > 0
        clock.now_ns += round(SECOND / pace.timesteps_per_second) if running else TICK_NS
        screen = conductor.screen
        if screen is not None:
            for stroke in operator.act(screen, clock.now_ns):
                if conductor.finished:
                    return
                conductor.feed(KeyChanged(clock.now_ns, stroke.key, stroke.down, poll_gap_ns=0))
                if stroke.down and len(stroke.key) == 1 and _takes_text(conductor.screen):
                    conductor.feed(TextTyped(clock.now_ns, stroke.key))
        idle_ticks = 0 if running else idle_ticks + 1
        if idle_ticks > STALLED_TICKS:
            raise StudyError(f"the simulated operator found no way on from {type(screen).__name__}")
        if running and conductor.pace.timesteps_per_second > 0 and not conductor.finished:
            conductor.feed(TimestepDue(clock.now_ns, late_ns=0))


def _awaits(conductor: Conductor) -> bool:
    """Whether an answer is on its way: of the fleet, with its pictures, or of the fitter."""
    return conductor.fleet_pending or conductor.pictures_pending or conductor.fit_pending


def _takes_text(screen: Screen | None) -> bool:
    """Whether characters reach the session too, as a window's do."""
    return isinstance(screen, SurveyScreen) and screen.takes_text
