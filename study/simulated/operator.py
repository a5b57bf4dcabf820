"""A simulated operator: it sees screens, and presses keys."""

from __future__ import annotations

from typing import Protocol

from study.questionnaire import TENS_FROM
from study.screens import (
    BreakScreen,
    CountdownScreen,
    EndScreen,
    FleetScreen,
    PageScreen,
    PauseScreen,
    RevealScreen,
    Screen,
    SurveyScreen,
    WaitScreen,
)
from study.seeding import generator
from study.simulated.blind_operator import BlindOperator
from study.simulated.driver_choice import MapSkill
from study.simulated.fleet_operator import FleetOperator
from study.simulated.keys import KeyStroke, tap
from study.simulated.laps import LapSkill, lap_parameters
from study.simulated.parameters import OperatorParameters
from study.simulated.ratings import Experience, Rater
from study.simulated.trained_user import TrainedUser

_GLIMPSE_S = 1.0
_HIGHEST_DIGIT = 9
_REMARK = "fine"
_USUAL_NUMBER = 30
"""What is asked for is most often an age."""


class Operator(Protocol):
    """Whoever is at the keyboard."""

    def act(self, screen: Screen, now_ns: int) -> tuple[KeyStroke, ...]:
        """Look at the screen and return the keys pressed and released, in order.

        Args:
            screen: what is shown now.
            now_ns: session time, virtual or real; never less than in the call before.
        """
        ...


class SimulatedOperator:
    """Drives, chooses, reads and rates like a crude person.

    It is asked once a timestep before a fleet and about every 100 ms elsewhere. The same
    parameters, seed, screens and times give the same keys.

    Args:
        parameters: what makes it differ from others.
        seed: seed of its own random stream.
        user: the synthetic user, who drives if the parameters say so.

    Raises:
        ValueError: the parameters name a trained user as driver, and there is none.
    """

    def __init__(
        self, parameters: OperatorParameters, seed: int, user: TrainedUser | None = None
    ) -> None:
        self.parameters = parameters
        random = generator(seed, "simulated_operator")
        self._experience = Experience()
        self._reader = FleetOperator(parameters, random, MapSkill(parameters, random, user))
        # Streams of their own, so that nothing changes for who never sees pictures or laps.
        self._blind = BlindOperator(generator(seed, "blind_operator"))
        on_laps, chance = lap_parameters(parameters), generator(seed, "lap_operator")
        self._laps = FleetOperator(on_laps, chance, LapSkill(on_laps, chance))
        self._fleet: FleetOperator | BlindOperator = self._reader
        self._rater = Rater(parameters, random)
        self._heading = ""
        self._place: tuple[object, ...] = ()
        self._ready_ns = 0

    @property
    def noticed(self) -> tuple[int, ...]:
        """Return the robots (from 0) that the latest call of `act` looked at, in order."""
        return self._fleet.noticed

    def act(self, screen: Screen, now_ns: int) -> tuple[KeyStroke, ...]:
        """Look at the screen and return the keys pressed and released, in order."""
        if isinstance(screen, FleetScreen):
            if screen.heading != self._heading:
                # Another part of the session, or another block: what is rated begins anew.
                self._heading = screen.heading
                self._experience = Experience()
            self._place = ()
            if screen.scene.gates:
                self._fleet = self._laps
            else:
                self._fleet = self._blind if screen.scene.pictures_only else self._reader
            return self._fleet.act(screen, self._experience, now_ns)
        released = self._fleet.leave()
        return released + self._read(screen, now_ns)

    def _read(self, screen: Screen, now_ns: int) -> tuple[KeyStroke, ...]:
        """Take the time that a screen takes to read, then answer it or go on."""
        place = _place_of(screen)
        if place != self._place:
            self._place = place
            self._ready_ns = now_ns + round(self._reading_s(screen) * 1e9)
            if isinstance(screen, RevealScreen):
                self._experience.see_reveal(screen)
        if now_ns < self._ready_ns or isinstance(screen, WaitScreen | CountdownScreen):
            return ()
        # Should a key do nothing, it is pressed again after a while: there is no dead end.
        self._ready_ns = now_ns + round(_GLIMPSE_S * 1e9)
        if isinstance(screen, SurveyScreen):
            return self._answer(screen)
        return tap("return")

    def _answer(self, screen: SurveyScreen) -> tuple[KeyStroke, ...]:
        """Answer the focused question, go to an open one, or confirm."""
        if screen.complete or all(item.value is not None for item in screen.items):
            return tap("return")
        if screen.focus >= len(screen.items) or screen.items[screen.focus].value is not None:
            return tap("tab")
        item = screen.items[screen.focus]
        if item.kind == "number":
            return _typed(str(min(item.high, max(item.low, _USUAL_NUMBER))), item.typed)
        if item.kind == "choice":
            return tap("1")
        if item.kind == "text":
            return _typed(_REMARK, item.typed)
        answer = self._rater.answer(item, self._experience)
        if item.high > _HIGHEST_DIGIT:
            # Where a digit alone counts for tens, two are typed; the focus stays.
            digits = f"{answer:02}" if item.high >= TENS_FROM else str(answer)
            return (*_typed(digits, ""), *tap("tab"))
        return tap(str(answer))

    def _reading_s(self, screen: Screen) -> float:
        parameters = self.parameters
        if isinstance(screen, PageScreen):
            text = " ".join((screen.title, screen.subtitle, *screen.paragraphs))
            seconds = len(text.split()) / parameters.words_per_second
            return max(parameters.page_minimum_s, seconds)
        if isinstance(screen, BreakScreen):
            return float(screen.wait_seconds)
        if isinstance(screen, SurveyScreen):
            open_items = [item for item in screen.items if item.value is None]
            words = len(open_items[0].text.split()) if open_items else 0
            return words / parameters.words_per_second + parameters.answer_delay_s
        return parameters.page_minimum_s


def _typed(text: str, before: str) -> tuple[KeyStroke, ...]:
    """Return the strokes that type a text in place of the one before."""
    keys = ["backspace"] * len(before) + list(text)
    return tuple(stroke for key in keys for stroke in tap(key))


def _place_of(screen: Screen) -> tuple[object, ...]:
    """Return what tells one screen to read from the next, without comparing whole maps."""
    match screen:
        case PageScreen():
            return ("page", screen.header_left, screen.header_right, screen.title)
        case SurveyScreen():
            answers = tuple((item.item, item.value) for item in screen.items)
            return ("survey", screen.header_left, screen.title, screen.focus, answers)
        case RevealScreen():
            return ("reveal", screen.header_left, screen.block)
        case BreakScreen():
            return ("break", screen.seconds_total)
        case PauseScreen():
            return ("pause", screen.confirm_stop)
        case WaitScreen() | EndScreen():
            return (screen.title,)
        case _:
            return ()
