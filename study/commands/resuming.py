"""Going on with a session that broke off: found, replayed up to a boundary, taken up again."""

from __future__ import annotations

import dataclasses
import hashlib
import re
import time
from collections import deque
from collections.abc import Iterable
from pathlib import Path

from study.enrolment.refusals import withdrawn
from study.errors import RecordingError, StudyError
from study.events.events import FitApplied, FitRequested, SessionEnded, StageEntered
from study.events.inputs import FitCompleted, Input, SessionOpened, SessionResumed
from study.loading import LoadedProtocol
from study.protocol import parse_protocol
from study.recording.enrolled import tombstones
from study.recording.file_lock import is_held
from study.recording.parts import (
    SessionRecording,
    join_parts,
    part_number,
    recordings_in,
)
from study.recording.reader import Recording, read_recording
from study.recording.register_folders import recordings_under
from study.recording.wire import decode, encode, record_types_by_topic
from study.session.session import Session

WRITER_PATIENCE_S = 5.0
"""How long a writer that still completes the file of a killed study is waited for."""

_POLL_S = 0.05


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class RestoredFit:
    """A fit that was in force at the boundary: what the fleet needs of it."""

    artefact_id: str
    kind: str
    algorithm: str
    weights: bytes


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Boundary:
    """A session as it was when the last stage had just been entered.

    Attributes:
        recording: what it was restored from.
        opened: its first input.
        session: fed with everything up to the boundary.
        fits: those in force, each checked against the hash recorded when it was applied.
        after_sequence: the last record that belongs to the session.
    """

    recording: SessionRecording
    opened: SessionOpened
    session: Session
    fits: tuple[RestoredFit, ...]
    after_sequence: int


@dataclasses.dataclass(frozen=True, slots=True)
class End:
    """Where the files of a session end, whatever of them belongs to it.

    Attributes:
        part: number of the last part.
        sequence: largest sequence number.
        t_ns: latest session time.
        log_time_ns: latest wall time, ns since 1970, UTC.
    """

    part: int
    sequence: int
    t_ns: int
    log_time_ns: int

    def resumed(self, after_sequence: int, t_ns: int, wall_ns: int) -> SessionResumed:
        """Return the first input of the next part.

        Args:
            after_sequence: the last record that belongs to the session.
            t_ns: session time now.
            wall_ns: wall time now, ns since 1970, UTC.
        """
        return SessionResumed(
            t_ns=t_ns,
            part=self.part + 1,
            after_sequence=after_sequence,
            gap_seconds=max(0.0, (wall_ns - self.log_time_ns) / 1e9),
        )


def find_boundary(loaded: LoadedProtocol, participant: str, folder: Path) -> Boundary:
    """Find the session to go on with and restore it up to its last boundary.

    Args:
        loaded: the protocol, which must be the recorded one to the byte.
        participant: whose last session is meant.
        folder: where the study's recordings are.

    Raises:
        StudyError: there is no such session, it is complete, follows another protocol, is still
            being written, or cannot be restored.
    """
    _wait_for_writers(folder, loaded, participant)
    recording = last_session(loaded, participant, folder)
    if recording is None:
        if participant in tombstones(folder).get(loaded.protocol.study.name, {}):
            raise withdrawn(participant)
        raise _not_there(loaded.protocol.study.name, participant, folder)
    if is_complete(recording):
        raise StudyError(
            f'the session of participant "{participant}" is complete: {recording.path.name}',
            "There is nothing to go on with. For another session say --again.",
        )
    opened = opened_session(recording)
    if opened.protocol_sha256 != loaded.sha256:
        raise StudyError(
            f"{loaded.path} is not the protocol that the session began with: its SHA-256 is "
            f"{loaded.sha256}, recorded in {recording.path.name} is {opened.protocol_sha256}",
            f"Give the file as it was: `study protocol {recording.path}` writes it anew.",
        )
    return restore(recording)


def _not_there(study: str, participant: str, folder: Path) -> StudyError:
    """Return the refusal of a participant of whom nothing lies beside the register."""
    beginning = f"{study}_{participant}_"
    found = [path for path in recordings_under(folder) if path.name.startswith(beginning)]
    moved = [path for path in found if path.parent.absolute() != folder.absolute()]
    hint = "Check id and folder, or leave out --resume to start the session."
    if moved:
        hint = f"There is {moved[0]}: put it, with its other parts, into {folder}."
    elif found:
        hint = f"{found[0].name} broke off before the session began: start it without --resume."
    return StudyError(
        f'no recording of participant "{participant}" in the study {study} in {folder}', hint
    )


def last_session(loaded: LoadedProtocol, participant: str, folder: Path) -> SessionRecording | None:
    """Return the participant's session that was opened last; None if there is none.

    Raises:
        RecordingError: a file of that participant, by its name, cannot be read.
    """
    study = loaded.protocol.study.name
    found: list[Recording] = []
    for path in recordings_in(folder):
        try:
            recording = read_recording(path)
        except RecordingError as error:
            if path.name.startswith(f"{study}_{participant}_"):
                hint = f"{error.hint} To go on without this file, move it away.".strip()
                raise RecordingError(error.message, hint) from error
            continue
        if recording.metadata.get("participant", participant) == participant:
            found.append(recording)
    opened: list[tuple[str, SessionRecording]] = []
    for session in join_parts(found):
        try:
            first = opened_session(session)
        except RecordingError:
            continue
        name = parse_protocol(first.protocol_toml, "the recorded protocol").study.name
        if first.participant == participant and name == study:
            opened.append((first.started_utc, session))
    return max(opened, key=lambda item: item[0])[1] if opened else None


def is_complete(recording: SessionRecording) -> bool:
    """Return whether every stage of a session was passed."""
    return any(
        isinstance(ended, SessionEnded) and ended.complete
        for _, ended in recording.records(SessionEnded.topic)
    )


def opened_session(recording: SessionRecording) -> SessionOpened:
    """Return a session's first input.

    Raises:
        RecordingError: it is in none of the parts.
    """
    for _, opened in recording.records(SessionOpened.topic):
        if isinstance(opened, SessionOpened):
            return opened
    raise RecordingError(
        recording.without_first or f"{recording.path.name} holds no opened session",
        "Put all parts into one folder." if recording.without_first else "",
    )


def restore(recording: SessionRecording) -> Boundary:
    """Replay a session up to the last stage whose entry is recorded in full.

    Raises:
        RecordingError: no stage is, the recorded events do not follow from the inputs with this
            program, or a fit is not the one that was applied.
    """
    for last_input in reversed(_boundary_inputs(recording)):
        boundary = _replay(recording, last_input)
        if boundary is not None:
            return boundary
    raise RecordingError(
        f"{recording.path.name} breaks off before the first stage",
        "Start the session anew with --again.",
    )


def find_end(recording: SessionRecording) -> End:
    """Look for the latest number and time in all parts of a session."""
    known = record_types_by_topic()
    sequence = t_ns = log_time_ns = 0
    for part in recording.parts:
        epoch_ns = -1
        latest = 0
        for raw in part.raw():
            if not raw.sequence or raw.topic not in known:
                continue
            if epoch_ns < 0:
                # A part's log times are its records' own times plus one wall time.
                epoch_ns = raw.log_time_ns - decode(raw.topic, raw.data).t_ns
            latest = max(latest, raw.log_time_ns)
            sequence = max(sequence, raw.sequence)
        if epoch_ns >= 0:
            t_ns = max(t_ns, latest - epoch_ns)
            log_time_ns = max(log_time_ns, latest)
    last = max(part_number(part) for part in recording.parts)
    return End(last, sequence, t_ns, log_time_ns)


def _boundary_inputs(recording: SessionRecording) -> list[int]:
    """Return the numbers of the inputs that a stage was entered by, in order."""
    found: list[int] = []
    last_input = 0
    for raw in recording.raw("input", "event"):
        if raw.topic.startswith("input/"):
            last_input = raw.sequence
        elif raw.topic == StageEntered.topic and (not found or found[-1] != last_input):
            found.append(last_input)
    return found


def _replay(recording: SessionRecording, last_input: int) -> Boundary | None:
    """Replay up to an input; return None if its own events are not recorded in full."""
    session = Session()
    opened: SessionOpened | None = None
    expected: deque[tuple[str, bytes]] = deque()
    completed: dict[int, FitCompleted] = {}
    algorithms: dict[int, str] = {}
    fits: dict[str, RestoredFit] = {}
    after_sequence = 0
    for raw in recording.raw("input", "event"):
        if raw.topic.startswith("input/"):
            if raw.sequence > last_input:
                break
            if expected:
                raise _differs(recording, raw.sequence, f"{expected[0][0]} is missing before it")
            given: Input = decode(raw.topic, raw.data)  # type: ignore[assignment]
            if isinstance(given, SessionOpened):
                opened = given
            elif isinstance(given, FitCompleted):
                completed[given.request_id] = given
            step = session.handle(given)
            expected.extend((event.topic, encode(event)) for event in step.events)
            algorithms |= {
                event.request_id: event.algorithm
                for event in step.events
                if isinstance(event, FitRequested)
            }
        else:
            if raw.topic == FitApplied.topic:
                applied = decode(raw.topic, raw.data)
                assert isinstance(applied, FitApplied)  # noqa: S101 - by its topic
                fits[applied.artefact_id] = _restored(applied, completed, algorithms)
            if not expected or expected.popleft() != (raw.topic, raw.data):
                raise _differs(recording, raw.sequence, f"{raw.topic} does not follow")
        after_sequence = raw.sequence
    if expected or opened is None:
        return None
    return Boundary(recording, opened, session, tuple(fits.values()), after_sequence)


def _restored(
    applied: FitApplied, completed: dict[int, FitCompleted], algorithms: dict[int, str]
) -> RestoredFit:
    """Return the weights of a fit, which must be those that were applied."""
    answer = completed.get(applied.request_id)
    weights = answer.weights if answer else b""
    found = hashlib.sha256(weights).hexdigest()
    if found != applied.weights_sha256:
        raise RecordingError(
            f"the weights of {applied.artefact_id} have the SHA-256 {found}; those applied had "
            f"{applied.weights_sha256}",
            "The recording was changed; the session cannot go on from it.",
        )
    algorithm = algorithms.get(applied.request_id, "")
    return RestoredFit(applied.artefact_id, applied.kind, algorithm, weights)


def _differs(recording: SessionRecording, sequence: int, what: str) -> RecordingError:
    return RecordingError(
        f"{recording.path.name} does not replay: record {sequence}: {what}",
        "Records are missing, or another version of the program wrote it: see its metadata and "
        "`study replay --verify`. Resume with that version, or start anew with --again.",
    )


def _wait_for_writers(folder: Path, loaded: LoadedProtocol, participant: str) -> None:
    """Wait until no process writes a file of the participant any more.

    Raises:
        StudyError: one still does after a while.
    """
    name = re.compile(rf"{re.escape(loaded.protocol.study.name)}_{re.escape(participant)}_.*")
    deadline = time.monotonic() + WRITER_PATIENCE_S
    while held := _held(path for path in recordings_in(folder) if name.fullmatch(path.name)):
        if time.monotonic() > deadline:
            raise StudyError(
                f"{held} is still being written",
                "Another `study run` of this participant is open: end it first. If there is none, "
                "wait for its writer process, or end that.",
            )
        time.sleep(_POLL_S)


def _held(paths: Iterable[Path]) -> str:
    """Return the name of the first file that a living process writes; empty if there is none."""
    return next((path.name for path in paths if is_held(path)), "")
