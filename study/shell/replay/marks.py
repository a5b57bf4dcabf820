"""What a replay's timeline marks: stages, trials, takeovers, pauses and faults, from the events."""

from __future__ import annotations

import dataclasses
from typing import Literal

from study.errors import RecordingError
from study.events.codes import ChoiceSource, Phase
from study.events.events import (
    Deviation,
    Paused,
    Resumed,
    StageEntered,
    Switched,
    TimestepSkipped,
    TrialEnded,
    TrialStarted,
)
from study.events.inputs import SessionOpened, WindowChanged
from study.events.shell import DisplayOpened
from study.protocol import parse_protocol
from study.recording.parts import SessionRecording
from study.recording.wire import decode

SpanKind = Literal["stage", "trial", "survey", "pause"]
TakeoverBy = Literal["operator", "scorer", "suggestion"]
USUAL_SIZE = (1280, 960)
"""Of the window of a participant who had none: pixels."""
_BY: dict[int, TakeoverBy] = {
    ChoiceSource.OPERATOR: "operator",
    ChoiceSource.SCORER: "scorer",
    ChoiceSource.ACCEPTED_SUGGESTION: "suggestion",
}


@dataclasses.dataclass(frozen=True, slots=True)
class Span:
    """Something that lasted.

    Attributes:
        kind: what.
        first_ns, last_ns: session times.
        label: in words.
        trial_id: number of the fleet run in the session, from 0; -1 if it is none.
        operated: of a trial: whether somebody operates in it.
    """

    kind: SpanKind
    first_ns: int
    last_ns: int
    label: str
    trial_id: int = -1
    operated: bool = False


@dataclasses.dataclass(frozen=True, slots=True)
class Takeover:
    """Another robot came under control: when, which (index from 0), and by whose choice."""

    t_ns: int
    robot: int
    by: TakeoverBy


@dataclasses.dataclass(frozen=True, slots=True)
class Fault:
    """Something did not go as it should: when, and what, in words."""

    t_ns: int
    text: str


@dataclasses.dataclass(frozen=True, slots=True)
class Marks:
    """The timeline of a session.

    Attributes:
        participant: pseudonymous id.
        language: of what the participant read.
        last_ns: session time of the last record.
        spans: in order of their beginnings.
        takeovers, faults: in order.
        sizes: from when on the participant's window had which size, pixels.
    """

    participant: str
    language: str
    last_ns: int
    spans: tuple[Span, ...]
    takeovers: tuple[Takeover, ...]
    faults: tuple[Fault, ...]
    sizes: tuple[tuple[int, tuple[int, int]], ...]

    def of_kind(self, *kinds: SpanKind) -> tuple[Span, ...]:
        """Return the spans of some kinds."""
        return tuple(span for span in self.spans if span.kind in kinds)

    def at(self, t_ns: int, kind: SpanKind) -> Span | None:
        """Return the last span of a kind that a time lies in."""
        inside = [s for s in self.of_kind(kind) if s.first_ns <= t_ns < s.last_ns]
        return inside[-1] if inside else None

    def size_at(self, t_ns: int) -> tuple[int, int]:
        """Return the size of the participant's window at a time, pixels."""
        found = USUAL_SIZE
        for since_ns, size in self.sizes:
            if since_ns <= t_ns or found is USUAL_SIZE:
                found = size
        return found


class _Collector:
    """Takes the events in, and closes what is open at the end."""

    def __init__(self) -> None:
        self.opened: SessionOpened | None = None
        self.spans: list[Span] = []
        self.takeovers: list[Takeover] = []
        self.faults: list[Fault] = []
        self.sizes: list[tuple[int, tuple[int, int]]] = []
        self._stage: StageEntered | None = None
        self._trial: TrialStarted | None = None
        self._paused: Paused | None = None
        self._skipped_in = -1

    def take(self, record: object) -> None:
        """Take in one record."""
        match record:
            case SessionOpened():
                self.opened = record
            case StageEntered():
                self._end_stage(record.t_ns)
                self._stage = record
            case TrialStarted():
                self._trial = record
            case TrialEnded():
                self._end_trial(record.t_ns)
            case Switched() if record.to_robot >= 0:
                by = _BY.get(record.source, "scorer")
                self.takeovers.append(Takeover(record.t_ns, record.to_robot, by))
            case Paused():
                self._paused = record
            case Resumed():
                self._end_pause(record.t_ns)
            case Deviation():
                self.faults.append(Fault(record.t_ns, f"{record.code}: {record.text}"))
            case TimestepSkipped() if record.trial_id != self._skipped_in:
                # One mark a trial: they come in rows.
                self._skipped_in = record.trial_id
                self.faults.append(Fault(record.t_ns, "a timestep was skipped: the fleet was slow"))
            case DisplayOpened() if record.width > 0 and record.height > 0:
                self.sizes.append((record.t_ns, (record.width, record.height)))
            case WindowChanged() if record.change == "resized":
                self.sizes.append((record.t_ns, (record.width, record.height)))
            case _:
                pass

    def end(self, t_ns: int) -> None:
        """Close what is open."""
        self._end_trial(t_ns)
        self._end_stage(t_ns)
        self._end_pause(t_ns)

    def _end_stage(self, t_ns: int) -> None:
        if self._stage is None:
            return
        kind: SpanKind = "survey" if self._stage.kind in ("survey", "check") else "stage"
        self.spans.append(Span(kind, self._stage.t_ns, t_ns, _place(self._stage)))

    def _end_trial(self, t_ns: int) -> None:
        trial, self._trial = self._trial, None
        if trial is None:
            return
        robots = f"{trial.robots} robot{'' if trial.robots == 1 else 's'}"
        label = f"trial {trial.trial}, {robots}, trial_id {trial.trial_id}"
        operated = trial.allocation != "none"
        self.spans.append(Span("trial", trial.t_ns, t_ns, label, trial.trial_id, operated))

    def _end_pause(self, t_ns: int) -> None:
        paused, self._paused = self._paused, None
        if paused is not None:
            self.spans.append(Span("pause", paused.t_ns, t_ns, f"paused: {paused.reason}"))


def _place(stage: StageEntered) -> str:
    """Say in words where in the study a stage is."""
    phase = "" if stage.phase == Phase.PRACTICE else f"phase {stage.phase}"
    block = f"block {stage.block}" if stage.block else ""
    name = stage.name.replace("_", " ")
    if stage.kind == "trial":
        # The trial says the rest.
        name = "practice" if stage.phase == Phase.PRACTICE else ""
    return " · ".join(word for word in (phase, block, stage.condition, name) if word)


_TAKEN = (
    SessionOpened, StageEntered, TrialStarted, TrialEnded, Switched, Paused, Resumed, Deviation,
    TimestepSkipped, WindowChanged, DisplayOpened,
)  # fmt: skip


def read_marks(recording: SessionRecording) -> Marks:
    """Read a session's timeline, without replaying it.

    Raises:
        RecordingError: it cannot be read, or opens no session.
    """
    before = recording.losses[0].first if recording.losses else None
    topics = {taken.topic for taken in _TAKEN}
    collector = _Collector()
    last_ns = 0
    latest = None
    for raw in recording.raw("input", "event", "shell"):
        if before is not None and raw.sequence >= before:
            break
        if raw.topic in topics:
            collector.take(decode(raw.topic, raw.data))
        if not raw.topic.startswith("shell/"):
            latest = raw
    if latest is not None:
        last_ns = decode(latest.topic, latest.data).t_ns
    collector.end(last_ns)
    opened = collector.opened
    if opened is None:
        raise RecordingError(f"{recording.path.name} holds no opened session")
    return Marks(
        participant=opened.participant,
        language=parse_protocol(opened.protocol_toml, "the recorded protocol").study.language,
        last_ns=last_ns,
        spans=tuple(sorted(collector.spans, key=lambda span: (span.first_ns, span.last_ns))),
        takeovers=tuple(collector.takeovers),
        faults=tuple(collector.faults),
        sizes=tuple(collector.sizes),
    )
