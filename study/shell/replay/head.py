"""Where a replay stands: a session fed up to some moment, and what is to be seen then."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.events.inputs import FleetObserved, Input, SessionOpened
from study.recording.reader import RawRecord
from study.screens import CountdownScreen, FleetScreen, Screen
from study.session.context import Step
from study.session.effects import Show, StartFleet, StopFleet
from study.session.forking import fork
from study.session.session import Session
from study.shell.drawing.motion import Motion
from study.shell.replay.film import Film

NO_SCORES: npt.NDArray[np.float64] = np.zeros(0)


@dataclasses.dataclass(slots=True, eq=False)
class Head:
    """A session at one moment of its replay.

    Attributes:
        session: fed with all inputs up to the moment.
        last: the input fed last; None before the first.
        t_ns: session time of that input.
        screen: what is shown; None before the first screen.
        motion: where the robots shown came from.
        scores: the scorer's value of every robot now, [n]; empty without a scorer.
        film: what every robot did in its episode.
    """

    session: Session = dataclasses.field(default_factory=Session)
    last: RawRecord | None = None
    t_ns: int = -1
    screen: Screen | None = None
    motion: Motion = dataclasses.field(default_factory=Motion)
    scores: npt.NDArray[np.float64] = dataclasses.field(default_factory=lambda: NO_SCORES)
    film: Film = dataclasses.field(default_factory=Film)

    def feed(self, raw: RawRecord, given: Input) -> tuple[Screen, ...]:
        """Feed an input to the session; return the screens that it showed."""
        return self.take_note(raw, given, self.session.handle(given))

    def take_note(self, raw: RawRecord, given: Input, step: Step) -> tuple[Screen, ...]:
        """Take note of an input that was fed; return the screens that it showed."""
        self.last, self.t_ns = raw, max(self.t_ns, given.t_ns)
        if isinstance(given, SessionOpened):
            self.film.open(given)
        if isinstance(given, FleetObserved):
            self.scores = given.scores
            self.film.observe(given)
        shown: list[Screen] = []
        for effect in step.effects:
            self.film.ask(effect)
            if isinstance(effect, Show):
                shown.append(effect.screen)
                fleet = _fleet_of(effect.screen)
                if fleet is not None:
                    self.motion.observe(fleet)
            elif isinstance(effect, StartFleet | StopFleet):
                self.scores = NO_SCORES
        if shown:
            self.screen = shown[-1]
        return tuple(shown)

    def fork(self) -> Head:
        """Return another that goes on from here by itself."""
        return dataclasses.replace(
            self, session=fork(self.session), motion=self.motion.copy(), film=self.film.copy()
        )


def _fleet_of(screen: Screen) -> FleetScreen | None:
    """Return the fleet that a screen shows, if it shows one."""
    if isinstance(screen, CountdownScreen):
        return screen.fleet
    return screen if isinstance(screen, FleetScreen) else None
