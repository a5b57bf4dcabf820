"""What a console is told of a session, gathered from its records as they are made."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from study.console.wire import (
    Disk,
    Facts,
    Fit,
    Place,
    Remark,
    State,
    Status,
    Timing,
    Trial,
    tidy,
)
from study.events.events import (
    Deviation,
    FitApplied,
    FitRequested,
    Paused,
    Resumed,
    SessionEnded,
    SessionStarted,
    StageEntered,
    Timestep,
    TimestepSkipped,
    TrialEnded,
    TrialStarted,
)
from study.events.experimenter_records import ExperimenterCommanded, ExperimenterNoted
from study.events.fields import Record
from study.events.fit_events import FitGateJudged
from study.events.inputs import FitFailed, FitTimedOut, RecordingRestored, SessionResumed
from study.events.shell import DisplayOpened, FrameIntervals

MOST_REMARKS = 20
LONGEST_REMARK = 300
WHILE_S = 30.0
"""How long a while the timing of pictures tells of."""
_STEPS = 100
_LATE_PERIODS = 1.2
_SECOND = 1e9


class Tracker:
    """Takes every record of a session; `study.recording.tapped.Tap`.

    Args:
        facts: what does not change.

    Attributes:
        ended: the session's last event, once it came.
    """

    def __init__(self, facts: Facts) -> None:
        self._facts = facts
        self._stages = 0
        self._place = Place()
        self._trial: Trial | None = None
        self._timestep = self._skipped = 0
        self._still_since_ns = -1
        self._why = ""
        self._held = False
        self._part = 1
        self._period_s = 0.0
        self._frames: deque[tuple[int, int, int, float]] = deque(maxlen=64)
        self._steps: deque[int] = deque(maxlen=_STEPS)
        self._fits: dict[str, Fit] = {}
        self._fitting: dict[int, str] = {}
        self._deviations = _Remarks()
        self._notes = _Remarks()
        self.ended: SessionEnded | None = None

    def offer(self, record: Record, log_time_ns: int, sequence: int) -> None:  # noqa: ARG002
        """See one record."""
        take = _TAKEN.get(type(record))
        if take is not None:
            take(self, record)

    @property
    def state(self) -> State:
        """Whether the session runs, stands still, is held by the experimenter, or ended."""
        if self.ended is not None:
            return "ended"
        if self._still_since_ns < 0:
            return "running"
        return "held" if self._held else "paused"

    def status(self, t_ns: int, disk: Disk) -> Status:
        """Return all that a console shows.

        Args:
            t_ns: the session's time.
            disk: how far the recording has got.
        """
        still = self._still_since_ns
        trial = self._trial
        if trial is not None:
            trial = trial.model_copy(update={"timestep": self._timestep, "skipped": self._skipped})
        return Status(
            facts=self._facts,
            t_s=t_ns / _SECOND,
            state=self.state,
            why=self._why if still >= 0 else "",
            still_s=(t_ns - still) / _SECOND if still >= 0 else 0.0,
            place=self._place,
            trial=trial,
            disk=disk.model_copy(update={"part": self._part}),
            timing=self._timing(t_ns),
            fits=tuple(self._fits.values()),
            deviations=tuple(self._deviations.kept),
            deviations_left_out=self._deviations.left_out,
            notes=tuple(self._notes.kept),
            notes_left_out=self._notes.left_out,
        )

    def _timing(self, t_ns: int) -> Timing:
        since = t_ns - round(WHILE_S * _SECOND)
        recent = [row for row in self._frames if row[0] >= since]
        steps = np.diff(np.array(self._steps, dtype=np.float64)) / 1e6
        return Timing(
            seconds=WHILE_S,
            frames=sum(row[1] for row in recent),
            late=sum(row[2] for row in recent),
            period_ms=1e3 * self._period_s,
            longest_ms=1e3 * max((row[3] for row in recent), default=0.0),
            step_ms=float(steps.mean()) if steps.size else None,
            step_longest_ms=float(steps.max()) if steps.size else None,
        )

    # Each kind of record

    def _started(self, record: SessionStarted) -> None:
        self._stages = record.stages

    def _stage(self, record: StageEntered) -> None:
        self._place = Place(
            number=record.stage + 1,
            stages=self._stages,
            kind=record.kind,
            name=record.name,
            phase=record.phase,
            block=record.block,
            condition=record.condition,
        )

    def _trial_started(self, record: TrialStarted) -> None:
        self._timestep = self._skipped = 0
        self._steps.clear()
        self._trial = Trial(
            trial_id=record.trial_id,
            number=record.trial,
            robots=record.robots,
            allocation=record.allocation,
            timestep=0,
            timesteps=record.timesteps,
            skipped=0,
        )

    def _step(self, record: Timestep) -> None:
        self._timestep = record.timestep + 1
        self._steps.append(record.due_ns)

    def _skip(self, _: TimestepSkipped) -> None:
        self._skipped += 1

    def _trial_ended(self, _: TrialEnded) -> None:
        self._trial = None
        self._steps.clear()

    def _pause(self, record: Paused) -> None:
        self._still_since_ns, self._why = record.t_ns, record.reason

    def _resume(self, _: Resumed) -> None:
        self._still_since_ns, self._held = -1, False
        # The interval over the pause says nothing.
        self._steps.clear()

    def _command(self, record: ExperimenterCommanded) -> None:
        if record.command in ("pause", "resume"):
            self._held = record.command == "pause"

    def _deviate(self, record: Deviation) -> None:
        text = tidy(record.text)[:LONGEST_REMARK]
        self._deviations.add(Remark(t_s=record.t_ns / _SECOND, code=record.code, text=text))

    def _note(self, record: ExperimenterNoted) -> None:
        self._notes.add(Remark(t_s=record.t_ns / _SECOND, text=record.text))

    def _display(self, record: DisplayOpened) -> None:
        self._period_s = 1 / record.refresh_hz if record.refresh_hz > 0 else 0.0

    def _frame(self, record: FrameIntervals) -> None:
        intervals = record.intervals
        if intervals.size:
            late = int(np.count_nonzero(intervals > _LATE_PERIODS * self._period_s))
            self._frames.append((record.t_ns, intervals.size, late, float(intervals.max())))

    def _fit(self, record: FitRequested) -> None:
        self._fitting[record.request_id] = record.artefact_id
        self._fits[record.artefact_id] = Fit(artefact_id=record.artefact_id, state="being fitted")

    def _fitted(self, record: FitApplied) -> None:
        found: Mapping[str, float] = dict(
            zip(record.metric_names, record.metric_values.tolist(), strict=False)
        )
        gain = _number(found, "held_out_log_likelihood_per_choice")
        chance = _number(found, "held_out_chance_log_likelihood")
        self._change(
            record.artefact_id,
            state="in use",
            likelihood_gain=None if gain is None or chance is None else gain - chance,
            top1=_number(found, "held_out_top1"),
            chance_top1=_number(found, "held_out_chance_top1"),
        )

    def _judged(self, record: FitGateJudged) -> None:
        before = self._fits.get(record.artefact_id)
        states = {
            "use": "in use",
            "go_on": before.state if before else "in use",
            "repeat": "to be repeated",
            "fallback": f"replaced by {record.fallback}",
            "end": "ends the session",
        }
        self._change(
            record.artefact_id,
            state=states.get(record.decision, record.decision),
            gate="passed" if record.passed else "not passed",
            reason=tidy(record.reason)[:LONGEST_REMARK],
        )

    def _fit_failed(self, record: FitFailed) -> None:
        if name := self._fitting.get(record.request_id):
            self._change(name, state="failed", reason=tidy(record.reason)[:LONGEST_REMARK])

    def _fit_late(self, record: FitTimedOut) -> None:
        if name := self._fitting.get(record.request_id):
            self._change(name, state="timed out")

    def _change(self, artefact_id: str, **changes: object) -> None:
        before = self._fits.get(artefact_id) or Fit(artefact_id=artefact_id, state="")
        self._fits[artefact_id] = before.model_copy(update=changes)

    def _another_part(self, record: RecordingRestored | SessionResumed) -> None:
        self._part = record.part

    def _end(self, record: SessionEnded) -> None:
        self.ended = record


class _Remarks:
    """The last remarks, and how many came before them."""

    def __init__(self) -> None:
        self.kept: deque[Remark] = deque(maxlen=MOST_REMARKS)
        self.left_out = 0

    def add(self, remark: Remark) -> None:
        self.left_out += len(self.kept) == MOST_REMARKS
        self.kept.append(remark)


def _number(found: Mapping[str, float], name: str) -> float | None:
    value = found.get(name, math.nan)
    return value if math.isfinite(value) else None


_TAKEN: Final[dict[type[Record], Callable[[Tracker, Any], None]]] = {
    SessionStarted: Tracker._started,
    StageEntered: Tracker._stage,
    TrialStarted: Tracker._trial_started,
    Timestep: Tracker._step,
    TimestepSkipped: Tracker._skip,
    TrialEnded: Tracker._trial_ended,
    Paused: Tracker._pause,
    Resumed: Tracker._resume,
    ExperimenterCommanded: Tracker._command,
    Deviation: Tracker._deviate,
    ExperimenterNoted: Tracker._note,
    DisplayOpened: Tracker._display,
    FrameIntervals: Tracker._frame,
    FitRequested: Tracker._fit,
    FitApplied: Tracker._fitted,
    FitGateJudged: Tracker._judged,
    FitFailed: Tracker._fit_failed,
    FitTimedOut: Tracker._fit_late,
    RecordingRestored: Tracker._another_part,
    SessionResumed: Tracker._another_part,
    SessionEnded: Tracker._end,
}
TOPICS: Final = tuple(record.topic for record in _TAKEN if record is not Timestep)
"""What a tracker is fed with of a session that is resumed."""
