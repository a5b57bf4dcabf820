"""What session and console say to each other: one JSON object a line, each line bounded.

The console says commands; the session says its state about four times a second, an answer to each
command, and last how it ended. Nothing else is ever said, and nothing that is said is run.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from study.errors import StudyError

LONGEST_COMMAND = 8192
"""Bytes of a line that the session takes."""
LONGEST_STATUS = 1 << 18
"""Bytes of a line that the console takes."""
LONGEST_TEXT = 500
"""Characters of a note or a reason."""

CommandName = Literal["pause", "resume", "annotate", "end"]
State = Literal["running", "paused", "held", "ended"]


class _Said(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore", ser_json_inf_nan="null")


class Command(BaseModel):
    """What the experimenter asks for.

    Attributes:
        command: what is to be done.
        text: the note, or the reason to end.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    command: CommandName
    text: str = Field(default="", max_length=4 * LONGEST_TEXT)


class Answer(_Said):
    """What became of a command.

    Attributes:
        command: which one; empty if it could not be understood.
        refused: why it was not done, in words; empty if it was.
    """

    kind: Literal["answer"] = "answer"
    command: str = ""
    refused: str = ""


class Ended(_Said):
    """The last that a session says.

    Attributes:
        complete: whether every stage was passed.
        reason: why it ended.
    """

    kind: Literal["ended"] = "ended"
    complete: bool
    reason: str


class Facts(_Said):
    """What does not change in a session."""

    session_id: str
    participant: str
    study: str
    order: tuple[str, ...]
    started_utc: str
    file: str
    pid: int


class Place(_Said):
    """Where the session is.

    Attributes:
        number: of the stage, from 1.
        stages: how many are planned.
        phase: 0 for practice.
    """

    number: int = 0
    stages: int = 0
    kind: str = ""
    name: str = ""
    phase: int = 0
    block: int = 0
    condition: str = ""


class Trial(_Said):
    """The fleet run under way."""

    trial_id: int
    number: int
    robots: int
    allocation: str
    timestep: int
    timesteps: int
    skipped: int


class Disk(_Said):
    """How far the recording has reached the disk.

    Attributes:
        unsaved_s: how old the oldest record is that is not known to be on disk; 0 if all are.
        working: whether the writer works.
    """

    sent: int
    durable: int
    unsaved_s: float
    working: bool
    part: int


class Timing(_Said):
    """How punctual pictures and timesteps were lately; ms.

    Attributes:
        seconds: how long a while it tells of.
        frames: pictures in it.
        late: of these, later than 1.2 periods.
        period_ms: between two pictures of the display.
        longest_ms: between two pictures.
        step_ms: mean interval between the last timesteps; None without any.
        step_longest_ms: longest of these.
    """

    seconds: float = 0.0
    frames: int = 0
    late: int = 0
    period_ms: float = 0.0
    longest_ms: float = 0.0
    step_ms: float | None = None
    step_longest_ms: float | None = None


class Fit(_Said):
    """One fit, and what its gate said.

    Attributes:
        state: "being fitted", "in use", "failed", "timed out", or the gate's decision.
        likelihood_gain: held-out log-likelihood a choice above chance, nats; None if not measured.
        top1: held-out share of choices that it foretold.
        chance_top1: what chance would foretell.
        gate: "passed", "not passed", or empty without a gate.
        reason: why not, in words.
    """

    artefact_id: str
    state: str
    likelihood_gain: float | None = None
    top1: float | None = None
    chance_top1: float | None = None
    gate: str = ""
    reason: str = ""


class Remark(_Said):
    """A deviation or a note.

    Attributes:
        t_s: when, s since the session opened.
        code: of a deviation; empty for a note.
    """

    t_s: float
    code: str = ""
    text: str


class Status(_Said):
    """All that a console shows.

    Attributes:
        t_s: the session's time, s.
        state: "held": paused by the experimenter.
        why: why it stands still; empty if it does not.
        still_s: for how long it has.
        remarks_left_out: earlier deviations that are not listed.
        notes_left_out: earlier notes that are not listed.
    """

    kind: Literal["status"] = "status"
    facts: Facts
    t_s: float
    state: State
    why: str = ""
    still_s: float = 0.0
    place: Place
    trial: Trial | None = None
    disk: Disk
    timing: Timing
    fits: tuple[Fit, ...] = ()
    deviations: tuple[Remark, ...] = ()
    deviations_left_out: int = 0
    notes: tuple[Remark, ...] = ()
    notes_left_out: int = 0


Said = Annotated[Status | Answer | Ended, Field(discriminator="kind")]
_SAID: TypeAdapter[Status | Answer | Ended] = TypeAdapter(Said)


def parse_command(line: bytes) -> Command:
    """Return the command in a line, its text on one line and printable.

    Raises:
        StudyError: it is none; the message says why.
    """
    if len(line) > LONGEST_COMMAND:
        raise StudyError(f"a line of {len(line)} bytes; at most {LONGEST_COMMAND} are read")
    try:
        given = Command.model_validate_json(line)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])[:60]
        what = f"{where}: {first['msg']}" if where else first["msg"]
        raise StudyError(f"no command was understood: {what[:200]}") from None
    text = tidy(given.text)
    if len(text) > LONGEST_TEXT:
        raise StudyError(f"{len(text)} characters; a text has at most {LONGEST_TEXT}")
    if given.command in ("annotate", "end") and not text:
        needed = "a note" if given.command == "annotate" else "a reason"
        raise StudyError(f'"{given.command}" needs {needed}')
    if given.command in ("pause", "resume") and text:
        raise StudyError(f'"{given.command}" takes no text')
    return Command(command=given.command, text=text)


def tidy(text: str) -> str:
    """Return a text on one line, without what cannot be printed."""
    return "".join(sign for sign in " ".join(text.split()) if sign.isprintable())


def parse_said(line: bytes) -> Status | Answer | Ended:
    """Return what a session said in a line.

    Raises:
        StudyError: it is nothing that this version knows.
    """
    try:
        return _SAID.validate_json(line)
    except ValidationError as error:
        raise StudyError(
            "the session says what this console does not understand",
            "Use the console of the version that runs the session.",
        ) from error
