"""Feeds the session, records what goes in and comes out, and carries out its effects."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from study.errors import RecordingFailedError
from study.events.events import Event, TrialEnded, TrialStarted
from study.events.fields import Record
from study.events.inputs import (
    FitCompleted,
    FitFailed,
    FitTimedOut,
    FleetObserved,
    Input,
    RobotReported,
)
from study.screens import Screen, WaitScreen
from study.session.context import Step
from study.session.effects import (
    Effect,
    EnsureDurable,
    EraseRecording,
    Finish,
    RequestFit,
    SetPace,
    Show,
    StartFleet,
    StepFleet,
    StopFleet,
)
from study.session.session import Session
from study.shell.fitting import FitAnswer, Fitter
from study.shell.fleet import Fleet
from study.shell.fleet_host import FleetAnswer
from study.shell.picture_packing import Packed
from study.shell.picture_records import PictureRecords

DURABLE_TIMEOUT_S = 10.0

Watcher = Callable[[Sequence[tuple[int, Event]]], None]
"""Sees the events of one input with their sequence numbers. It must not raise nor wait."""


class Recorder(Protocol):
    """What the conductor needs of a recorder."""

    def write(self, record: Record, log_time_ns: int) -> int:
        """Hand a record to the writer."""
        ...

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Hand over records all or none of which are to be in the file."""
        ...

    def ensure_durable(self, timeout_s: float) -> bool:
        """Wait until everything written is on disk, with another writer if one fails."""
        ...


class Conductor:
    """One session's hands.

    Args:
        session: the state machine.
        recorder: where records go.
        fleet: what steps the robots.
        fitter: what fits.
        epoch_ns: wall time at which the session's monotonic time is 0.
        waits_for_disk: whether EnsureDurable waits; simulated participants lose nothing
            that could not be simulated again.
        on_show: called with every screen that is to be shown.
        on_pictures: called with the pictures that the task took of its robots, see
            `study.tasks.base.PicturedTask`, before the screen that they belong to.
        picture_records: makes records of them; None where none are recorded.
    """

    def __init__(
        self,
        session: Session,
        recorder: Recorder,
        fleet: Fleet,
        fitter: Fitter,
        *,
        epoch_ns: int,
        waits_for_disk: bool,
        on_show: Callable[[Screen], None] | None = None,
        on_pictures: Callable[[npt.NDArray[np.uint8]], None] | None = None,
        picture_records: PictureRecords | None = None,
    ) -> None:
        self.session = session
        self._recorder = recorder
        self._fleet = fleet
        self._fitter = fitter
        self._epoch_ns = epoch_ns
        self._waits_for_disk = waits_for_disk
        self._on_show = on_show
        self._on_pictures = on_pictures
        self._picture_records = picture_records
        self._fleet_request = -1
        self._fits_pending = 0
        self.screen: Screen | None = None
        self.pace = SetPace(0.0)
        self.pace_changed = False
        self.finished = False
        self.erase_asked = False
        self.trial_id = -1
        self.longest_disk_wait_s = 0.0
        self._watchers: list[Watcher] = []

    def watch(self, watcher: Watcher) -> None:
        """Let a watcher see all further events, once they were handed to the recorder."""
        self._watchers.append(watcher)

    def observe(self, record: Record) -> None:
        """Record what the shell noticed; the session does not hear of it."""
        self._recorder.write(record, self._epoch_ns + record.t_ns)

    def feed(self, given: Input) -> None:
        """Hand an input to the session, record it with its events, carry out the effects.

        Input and events are recorded together, before any effect: wherever the study is killed,
        a recording holds for each of its inputs all that followed from it.
        """
        step = self._handled(given)
        records: list[Record] = [given, *step.events]
        last = self._recorder.write_together(
            [(record, self._epoch_ns + record.t_ns) for record in records]
        )
        for event in step.events:
            if isinstance(event, TrialStarted):
                self.trial_id = event.trial_id
            elif isinstance(event, TrialEnded):
                self.trial_id = -1
        if step.events:
            numbered = list(enumerate(step.events, last - len(step.events) + 1))
            for watcher in self._watchers:
                watcher(numbered)
        for effect in step.effects:
            self._carry_out(effect)

    def _handled(self, given: Input) -> Step:
        try:
            return self.session.handle(given)
        except BaseException:
            # A fault of ours: the recording should show what led to it.
            self._recorder.write(given, self._epoch_ns + given.t_ns)
            raise

    def _carry_out(self, effect: Effect) -> None:
        if isinstance(effect, Show):
            self.screen = effect.screen
            if self._on_show:
                self._on_show(effect.screen)
        elif isinstance(effect, StartFleet | StepFleet):
            self._fleet_request = effect.request_id
            # Nobody looks at a fleet while a screen asks to wait.
            seen = not isinstance(self.screen, WaitScreen)
            records = self._picture_records
            self._fleet.request(
                effect,
                pictures=seen and self._on_pictures is not None,
                keep=records is not None and records.asked(effect, seen=seen),
            )
        elif isinstance(effect, RequestFit):
            self._fits_pending += 1
            self._fitter.request(effect)
        elif isinstance(effect, SetPace):
            self.pace, self.pace_changed = effect, True
        elif isinstance(effect, EnsureDurable):
            self._ensure_durable()
        elif isinstance(effect, EraseRecording):
            self.erase_asked = True
        elif isinstance(effect, Finish):
            self.finished = True
        elif isinstance(effect, StopFleet):
            self._fleet_request = -1

    def _ensure_durable(self) -> None:
        if not self._waits_for_disk:
            return
        began = time.perf_counter()
        if not self._recorder.ensure_durable(DURABLE_TIMEOUT_S):
            raise RecordingFailedError(
                f"the recording did not reach the disk within {DURABLE_TIMEOUT_S:g} s",
                "Check the disk; what was recorded before is kept.",
            )
        self.longest_disk_wait_s = max(self.longest_disk_wait_s, time.perf_counter() - began)

    @property
    def fleet_pending(self) -> bool:
        """Whether an answer of the fleet is awaited."""
        return self._fleet_request >= 0

    @property
    def pictures_pending(self) -> bool:
        """Whether pictures are on their way to the recording; nothing need wait for them."""
        return self._picture_records is not None and self._picture_records.awaited

    @property
    def fit_pending(self) -> bool:
        """Whether an answer of the fitter is awaited, be it to a fit in the background."""
        return self._fits_pending > 0

    def collect(self, now: Callable[[], int], wait_s: float = 0.0) -> bool:
        """Feed the answers of fleet and fitter that have come.

        Args:
            now: the session's time, asked when an answer is taken.
            wait_s: how long to wait for one that is awaited.

        Returns:
            Whether anything came.
        """
        came = False
        awaited = self.fleet_pending or self.pictures_pending
        fleet = self._fleet.poll(wait_s) if awaited else None
        while isinstance(fleet, Packed):
            self._record_pictures(fleet, now())
            fleet = self._fleet.poll()
        for report in fleet.reports if fleet is not None else ():
            self.feed(
                RobotReported(
                    now(),
                    report.robot,
                    report.stopped,
                    report.reason,
                    report.text,
                    round(1e9 * report.age_s),
                )
            )
        # A trial broken off may leave an answer behind: it is nobody's.
        if isinstance(fleet, FleetAnswer) and fleet.request_id == self._fleet_request:
            came = True
            self._fleet_request = -1
            if self._on_pictures and fleet.pictures is not None:
                self._on_pictures(fleet.pictures)
            self._take_answer(fleet, now())
        if self.fit_pending and (answer := self._fitter.poll(wait_s)) is not None:
            came = True
            self._fits_pending -= 1
            self._take_fit(answer, now())
        return came

    def _take_answer(self, answer: FleetAnswer, t_ns: int) -> None:
        trial_id = self.trial_id
        self.feed(
            FleetObserved(
                t_ns=t_ns,
                request_id=answer.request_id,
                robots=len(answer.states),
                states=answer.states,
                rewards=answer.rewards,
                outcomes=answer.outcomes,
                policy_actions=answer.policy_actions,
                scores=answer.scores,
            )
        )
        if self._picture_records is not None:
            # A fleet run may begin or end with its answer.
            trial_id = max(trial_id, self.trial_id)
            self._picture_records.answered(answer, t_ns, trial_id, self.screen, self._fleet)

    def _record_pictures(self, packed: Packed, now_ns: int) -> None:
        """Record pictures that have come; what keeps them off the recording ends no session."""
        if self._picture_records is None:
            return
        record = self._picture_records.packed(packed, now_ns)
        if record is not None:
            # Logged when they came, so that log times go on with the numbers.
            self._recorder.write(record, self._epoch_ns + now_ns)

    def _take_fit(self, answer: FitAnswer, t_ns: int) -> None:
        request = answer.request
        if answer.timed_out:
            self.feed(FitTimedOut(t_ns, request.request_id, request.budget_seconds))
        elif answer.reason:
            self.feed(FitFailed(t_ns, request.request_id, answer.reason))
        else:
            # Before the session hears of it: its next effect may already use the fit.
            if not request.background:
                self._fleet.add_artefact(
                    request.artefact_id, request.kind, request.algorithm, answer.weights
                )
            self.feed(
                FitCompleted(
                    t_ns=t_ns,
                    request_id=request.request_id,
                    artefact_id=request.artefact_id,
                    weights=answer.weights,
                    seconds=answer.seconds,
                    metric_names=tuple(answer.metrics),
                    metric_values=np.array(list(answer.metrics.values()), dtype=np.float64),
                    score_grid=answer.score_grid,
                    preparation=answer.preparation,
                )
            )
