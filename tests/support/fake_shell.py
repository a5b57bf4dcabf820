"""A shell without clock, fleet, fits or window: it answers the session with made-up data."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from study.events.codes import Outcome
from study.events.events import Event, StageEntered
from study.events.experimenter_records import ExperimenterCommanded
from study.events.inputs import (
    FitCompleted,
    FitFailed,
    FitTimedOut,
    FleetObserved,
    Input,
    KeyChanged,
    PointerPressed,
    RecordingInterrupted,
    RecordingRestored,
    SessionOpened,
    TextTyped,
    TimestepDue,
)
from study.recording.wire import decode, encode
from study.screens import (
    BreakScreen,
    FleetScreen,
    PauseScreen,
    Screen,
    SurveyScreen,
    WaitScreen,
)
from study.session.effects import (
    Effect,
    Finish,
    RequestFit,
    SetPace,
    Show,
    StartFleet,
    StepFleet,
)
from study.session.session import Session

STEP_NS = 100_000_000
READING_NS = 1_000_000_000
STATE_SIZE = 4
Alter = Callable[[dict[str, Any]], None]


@dataclasses.dataclass(frozen=True, slots=True)
class Moods:
    """What the made-up answers are like.

    Attributes:
        end_chance: chance at each timestep that a stepped robot's episode ends.
        longest_episode: timesteps after which it ends for certain.
        odd_chance: chance that an answer holds NaN and infinities.
        lawful: whether robots that were not stepped keep their outcome.
        fits: kinds of answers to fits, taken in turn.
        measures: measures of fit that completed fits come with.
    """

    end_chance: float = 0.05
    longest_episode: int = 12
    odd_chance: float = 0.0
    lawful: bool = True
    fits: tuple[str, ...] = ("completed",)
    measures: dict[str, float] = dataclasses.field(default_factory=dict)


class FakeShell:
    """Feeds a session and keeps what went in and came out, in order.

    Args:
        first: the input that opens the session.
        seed: of the made-up answers.
        moods: what they are like.
    """

    def __init__(self, first: SessionOpened, seed: int = 0, moods: Moods | None = None) -> None:
        self.session = Session()
        self.moods = moods or Moods()
        self._random = np.random.default_rng(seed)
        self.t_ns = 0
        self.inputs: list[Input] = []
        self.events: list[Event] = []
        self.effects: list[Effect] = []
        self.log: list[tuple[str, bytes]] = []
        self.fleet: StartFleet | StepFleet | None = None
        self.fits: deque[RequestFit] = deque()
        self.pace = 0.0
        self.screen: Screen | None = None
        self.finished = False
        self.interrupted = False
        self._outcomes = np.zeros(0, np.int32)
        self._lengths = np.zeros(0, np.int64)
        self._scored = False
        self._fits_answered = 0
        self.feed(first)

    # What goes in

    def feed(self, given: Input) -> tuple[Event, ...]:
        """Hand one input to the session, as the wire would; return its events."""
        self.inputs.append(given)
        step = self.session.handle(given)
        self.events += step.events
        if any(isinstance(event, StageEntered) for event in step.events):
            # Read first: a questionnaire is deaf to keys for its first half second.
            self.later(READING_NS)
        self.effects += step.effects
        self.log += [(event.topic, encode(event)) for event in step.events]
        for effect in step.effects:
            self._carry_out(effect)
        return step.events

    def _carry_out(self, effect: Effect) -> None:
        if isinstance(effect, StartFleet | StepFleet):
            self.fleet = effect
        elif isinstance(effect, RequestFit):
            self.fits.append(effect)
        elif isinstance(effect, SetPace):
            self.pace = effect.timesteps_per_second
        elif isinstance(effect, Show):
            self.screen = effect.screen
        elif isinstance(effect, Finish):
            self.finished = True

    def later(self, ns: int = STEP_NS) -> int:
        """Let time go on; return the new time."""
        self.t_ns += ns
        return self.t_ns

    def key(self, key: str, *, down: bool = True) -> tuple[Event, ...]:
        """Press or release a key."""
        return self.feed(KeyChanged(self.later(1_000_000), key, down, poll_gap_ns=0))

    def tap(self, key: str) -> tuple[Event, ...]:
        """Press and release a key."""
        return (*self.key(key), *self.key(key, down=False))

    def point(self, target: str) -> tuple[Event, ...]:
        """Press the mouse button on a target."""
        return self.feed(PointerPressed(self.later(1_000_000), 1.0, 2.0, target, poll_gap_ns=0))

    def due(self) -> tuple[Event, ...]:
        """Say that a timestep is due."""
        return self.feed(TimestepDue(self.later(), late_ns=0))

    def step(self, alter: Alter | None = None) -> tuple[Event, ...]:
        """Let one timestep be due and answered."""
        return (*self.due(), *self.answer_fleet(alter))

    def interrupt(self) -> tuple[Event, ...]:
        """Say that the writer of the recording failed."""
        self.interrupted = True
        return self.feed(RecordingInterrupted(self.later(1_000_000), "made up"))

    def restore(self, part: int = 2) -> tuple[Event, ...]:
        """Say that the recording works again, in another part or in the one there was."""
        self.interrupted = False
        return self.feed(RecordingRestored(self.later(1_000_000), part))

    def command(self, command: str, text: str = "") -> tuple[Event, ...]:
        """Let the experimenter ask for something at the console."""
        return self.feed(ExperimenterCommanded(self.later(1_000_000), command, text))

    # Made-up answers

    def answer_fleet(self, alter: Alter | None = None) -> tuple[Event, ...]:
        """Answer the fleet's request; ``alter`` may change the answer's fields in place."""
        request, self.fleet = self.fleet, None
        assert request is not None
        return self.feed(self.made_up(request, alter))

    def made_up(
        self, request: StartFleet | StepFleet, alter: Alter | None = None, request_id: int = -1
    ) -> FleetObserved:
        """Make up an answer to a request, or a stale one with another's id."""
        random, moods = self._random, self.moods
        if isinstance(request, StartFleet):
            robots = request.robots
            self._outcomes = np.zeros(robots, np.int32)
            self._lengths = np.zeros(robots, np.int64)
            self._scored = bool(request.scorer_id)
            active = np.zeros(robots, np.bool_)
        else:
            robots, active = len(request.actions), request.active
            self._outcomes = np.where(request.reset, 0, self._outcomes).astype(np.int32)
            self._lengths = np.where(request.reset, 0, self._lengths + active)
        over = self._lengths >= moods.longest_episode
        ends = active & ((random.random(robots) < moods.end_chance) | over)
        endings = random.integers(Outcome.GOAL, Outcome.TIME_UP + 1, robots)
        self._outcomes = np.where(ends, endings, self._outcomes).astype(np.int32)
        if not moods.lawful:
            self._outcomes = random.integers(0, 4, robots).astype(np.int32)
        fields: dict[str, Any] = {
            "states": random.uniform(0, 20, (robots, STATE_SIZE)).astype(np.float32),
            "rewards": np.where(active, random.normal(0, 5, robots), 0).astype(np.float32),
            "outcomes": self._outcomes.copy(),
            "policy_actions": random.integers(0, 4, robots).astype(np.int32),
            "scores": random.normal(0, 1, robots) if self._scored else np.empty(0),
        }
        if random.random() < moods.odd_chance:
            for name in ("states", "rewards", "scores"):
                array = fields[name]
                # Sums of huge and small rewards are only as exact as float64 is.
                huge = 1e4 if name == "rewards" else 3e38
                odd = np.array([np.nan, np.inf, -np.inf, huge, -huge, 0.0])
                array[...] = np.where(
                    random.random(array.shape) < 0.3, random.choice(odd, array.shape), array
                )
        if alter:
            alter(fields)
            self._outcomes = fields["outcomes"].copy()
        return FleetObserved(
            t_ns=self.t_ns,
            request_id=request.request_id if request_id < 0 else request_id,
            robots=robots,
            **fields,
        )

    def answer_fit(self, kind: str = "") -> tuple[Event, ...]:
        """Answer the oldest fit: "completed", "failed" or "timed out"; in turn if not said."""
        request = self.fits.popleft()
        kind = kind or self.moods.fits[self._fits_answered % len(self.moods.fits)]
        self._fits_answered += 1
        t_ns = self.later()
        if kind == "failed":
            return self.feed(FitFailed(t_ns, request.request_id, "made up [not] to work"))
        if kind == "timed out":
            return self.feed(FitTimedOut(t_ns, request.request_id, request.budget_seconds))
        return self.feed(
            FitCompleted(
                t_ns=t_ns,
                request_id=request.request_id,
                artefact_id=request.artefact_id,
                weights=self._random.bytes(16),
                seconds=0.5,
                metric_names=("rows", "loss", *self.moods.measures),
                metric_values=np.array(
                    [len(request.arrays["states"]), np.nan, *self.moods.measures.values()]
                ),
                score_grid=np.arange(6.0).reshape(1, 1, 2, 3)
                if request.kind == "scorer"
                else np.empty(0),
                preparation=self._random.bytes(8) if request.kind == "scorer" else b"",
            )
        )

    @property
    def fit(self) -> RequestFit | None:
        """Return the fit to be answered next; None if there is none."""
        return self.fits[0] if self.fits else None

    # Getting on

    def help(self) -> None:
        """Do the one thing that brings the session on."""
        screen = self.screen
        if self.interrupted:
            self.restore()
        elif isinstance(screen, PauseScreen):
            if not screen.can_go_on:
                self.command("resume")
            else:
                self.key("return")
        elif self.fleet is not None:
            self.answer_fleet()
        elif self.fit is not None:
            self.answer_fit()
        elif isinstance(screen, BreakScreen) and not screen.wait_seconds:
            self.key("return")
        elif self.pace > 0:
            self.due()
        elif isinstance(screen, SurveyScreen) and not screen.complete:
            self.answer_question(screen)
        else:
            self.key("return")

    def answer_question(self, screen: SurveyScreen) -> None:
        """Answer the question in focus, or go to the next."""
        item = screen.items[screen.focus] if screen.focus < len(screen.items) else None
        if item is None or item.value is not None:
            self.key("tab")
        elif item.kind == "text":
            self.feed(TextTyped(self.later(1_000_000), "fine"))
        elif item.kind == "number":
            for key in ["backspace"] * len(item.typed) + list(str(item.low)):
                self.key(key)
        else:
            # One of the first two is there in any choice.
            self.key(str(1 + int(self._random.integers(2 if item.kind == "choice" else 7))))

    def go_on_until(self, reached: Callable[[], bool], limit: int = 2_000) -> None:
        """Help until something holds."""
        for _ in range(limit):
            if reached() or self.finished:
                break
            self.help()
        assert reached(), f"not reached; the screen is {type(self.screen).__name__}"

    def go_to_trial(self, phase: int, condition: str = "", trial: int = 1) -> None:
        """Help until a trial has just started."""

        def reached() -> bool:
            from study.events.events import TrialStarted

            last = next((e for e in reversed(self.events) if isinstance(e, TrialStarted)), None)
            return (
                last is not None
                and (last.phase, last.condition, last.trial) == (phase, condition, trial)
                and not self.session.finished
            )

        self.go_on_until(reached)

    def fleet_screen(self) -> FleetScreen:
        """Return the screen, which must show a fleet."""
        assert isinstance(self.screen, FleetScreen), self.screen
        return self.screen

    def waiting(self) -> bool:
        """Whether something is being computed or driven without the operator."""
        return isinstance(self.screen, WaitScreen)


def replayed(inputs: list[Input]) -> list[tuple[str, bytes]]:
    """Feed a new session with inputs that went over the wire; return its encoded events."""
    session = Session()
    log: list[tuple[str, bytes]] = []
    for given in inputs:
        again: Any = decode(given.topic, encode(given))
        log += [(event.topic, encode(event)) for event in session.handle(again).events]
    return log
