"""The recordings of one study: found, opened, checked against one another."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from analysis.damaged import KnownTrials, broken_trials, unknown_trials
from analysis.left_out import LeftOut, SetAside, beside
from analysis.of_register import OfRegister
from analysis.places import UNKNOWN
from analysis.salvaged_copies import without_copies
from analysis.several_protocols import how_to_choose, protocols_in_words
from analysis.source import RecordingSource
from study.errors import ProtocolError, RecordingError, StudyError
from study.events.events import SessionEnded, TrialEnded, TrialStarted
from study.events.inputs import SessionOpened
from study.events.task_description import TaskDescription
from study.recording.enrolled import planned_orders, slots
from study.recording.exported import export_of
from study.recording.file_lock import is_held
from study.recording.parts import SessionRecording, join_parts, part_files
from study.recording.reader import Recording, read_recording
from study.toml_text import parse_toml

SUFFIX = ".mcap"


@dataclasses.dataclass(frozen=True, slots=True)
class Session:
    """One recording with what every table needs of it.

    Attributes:
        file: the file's name, without its folder.
        recording: its records.
        opened: the first input.
        ended: the last event, or None if the session has none.
        protocol: the protocol as recorded, parsed.
        task: what the task said of itself.
        trials: how each fleet run began, by trial id.
        trial_ends: how each finished fleet run ended, by trial id; one of which records are
            missing counts as incomplete.
        damaged_trials: ids of fleet runs of which records are missing.
        unknown_trials: how many timesteps are left out of each fleet run whose beginning is
            missing, by trial id.
        parts: the files of the session, in order.
        left_out_trials: fleet runs broken off by a crash, which a resume went back behind; they
            are in none of the data here.
        planned_order: the order of conditions that the plan had; empty if no register tells.
        slot: that the participant holds now, from 1; 0 for none, -1 if no register tells.
    """

    file: str
    recording: RecordingSource
    opened: SessionOpened
    ended: SessionEnded | None
    protocol: Mapping[str, Any]
    task: TaskDescription
    trials: Mapping[int, TrialStarted]
    trial_ends: Mapping[int, TrialEnded]
    damaged_trials: tuple[int, ...] = ()
    unknown_trials: Mapping[int, int] = dataclasses.field(default_factory=dict)
    parts: tuple[Recording, ...] = ()
    left_out_trials: int = 0
    planned_order: tuple[str, ...] = ()
    slot: int = UNKNOWN

    @property
    def files(self) -> tuple[tuple[str, str], ...]:
        """Each file of the session and its SHA-256, hexadecimal, in order."""
        named = tuple((part.path.name, part.sha256) for part in self.parts)
        return named or ((self.file, self.recording.sha256),)

    @property
    def complete(self) -> bool:
        """Whether every stage was passed and the file is whole."""
        return self.recording.complete and self.ended is not None and self.ended.complete


@dataclasses.dataclass(frozen=True, slots=True)
class StudyRecordings:
    """The sessions of a study, sorted by participant: one a participant.

    Attributes:
        sessions: those analysed; at least one.
        set_aside: those that are not, with the reason.
    """

    sessions: tuple[Session, ...]
    set_aside: tuple[SetAside, ...]

    @property
    def unreadable(self) -> int:
        """How many files cannot be used."""
        return sum(item.unreadable for item in self.set_aside)

    @property
    def first(self) -> Session:
        """The session whose protocol and task stand for all."""
        return self.sessions[0]

    @property
    def protocol_hashes(self) -> tuple[str, ...]:
        """Distinct SHA-256 of the protocols, sorted."""
        return tuple(sorted({session.opened.protocol_sha256 for session in self.sessions}))


def find_files(paths: Sequence[Path]) -> list[Path]:
    """Return the recordings among files and folders, sorted, each once.

    Raises:
        StudyError: a path does not exist, or there is no recording at all.
    """
    found: dict[Path, Path] = {}
    for path in paths:
        if path.is_dir():
            members = _members(path)
        elif path.is_file():
            members = part_files(path)
        else:
            raise StudyError(f"{path}: no such file or folder", "Give recordings or their folder.")
        found.update({member.resolve(): member for member in members})
    if not found:
        given = ", ".join(str(path) for path in paths)
        raise StudyError(
            f"no recording (*{SUFFIX}) in {given}",
            "Make some with `study simulate` or `study run`, or give another folder.",
        )
    return [found[key] for key in sorted(found)]


def _members(folder: Path) -> list[Path]:
    """Return the recordings of a folder, unfinished ones too."""
    torn = [path for path in folder.rglob(f"*{SUFFIX}.part") if not path.with_suffix("").exists()]
    return [*sorted(folder.rglob(f"*{SUFFIX}")), *torn]


def load_recordings(paths: Sequence[Path], *, pool: bool = False) -> StudyRecordings:
    """Open recordings, join the parts of each session and choose one session a participant.

    Files that cannot be used are set aside with the reason, not passed over in silence.

    Args:
        paths: files and folders.
        pool: pool recordings of different protocols.

    Raises:
        StudyError: nothing can be used, or protocols differ and ``pool`` is false.
    """
    recordings: list[Recording] = []
    sessions: list[Session] = []
    set_aside: list[SetAside] = []

    def leave_out(path: Path, error: RecordingError) -> None:
        # Outputs must not depend on where the files lie.
        reason = error.message.replace(str(path.resolve()), path.name)
        reason = reason.replace(str(path), path.name).removeprefix(f"{path.name}: ")
        # The file is named beside the reason already.
        if reason.startswith(f"{path.name} "):
            reason = f"it{reason.removeprefix(path.name)}"
        set_aside.append(SetAside(path.name, "", reason, unreadable=True))

    for path in find_files(paths):
        if is_held(path):
            set_aside.append(SetAside(path.name, "", "it is still being written"))
            continue
        if export := export_of(path):
            set_aside.append(SetAside(path.name, export.participant, str(export)))
            continue
        try:
            recordings.append(read_recording(path))
        except RecordingError as error:
            leave_out(path, error)
    register = LeftOut()
    plan: OfRegister[tuple[str, ...]] = OfRegister(planned_orders, ())
    places = OfRegister(slots, UNKNOWN)
    recordings, copies = without_copies(recordings)
    set_aside += copies
    for joined in join_parts(recordings):
        try:
            session = open_session(joined.path.name, joined)
            opened, study = session.opened, session.protocol.get("study", {}).get("name", "")
            whose = (study, opened.participant, opened.operator_kind)
            reason = register.reason(joined, *whose)
            if reason:
                set_aside.append(
                    SetAside(session.file, opened.participant, reason, opened.started_utc)
                )
                continue
            sessions.append(
                dataclasses.replace(
                    session,
                    parts=joined.parts,
                    left_out_trials=joined.left_out_trials,
                    planned_order=plan.of(joined.path.parent, *whose),
                    slot=places.of(joined.path.parent, *whose),
                )
            )
        except RecordingError as error:
            leave_out(joined.path, error)
    return choose_sessions(sessions, set_aside, pool=pool)


def open_session(file: str, recording: RecordingSource) -> Session:
    """Read what every table needs of a recording.

    Raises:
        RecordingError: it does not begin with an opened session, or that is unreadable.
    """
    opened = next(
        (r for _, r in recording.records(SessionOpened.topic) if isinstance(r, SessionOpened)), None
    )
    if opened is None:
        first = recording.without_first if isinstance(recording, SessionRecording) else ""
        why = first or f"{file}: holds no opened session"
        raise RecordingError(why, "Leave this file out.")
    try:
        protocol = parse_toml(opened.protocol_toml, "its protocol")
    except ProtocolError as error:
        reason = "; ".join(error.problems)
        raise RecordingError(f"{file}: its protocol is unreadable: {reason}") from error
    started: dict[int, TrialStarted] = {}
    ends: dict[int, TrialEnded] = {}
    began: dict[int, int] = {}
    over: dict[int, int] = {}
    ended: SessionEnded | None = None
    topics = (TrialStarted.topic, TrialEnded.topic, SessionEnded.topic)
    for sequence, record in recording.records(*topics):
        if isinstance(record, TrialStarted):
            started[record.trial_id] = record
            began[record.trial_id] = sequence
        elif isinstance(record, TrialEnded):
            ends[record.trial_id] = record
            over[record.trial_id] = sequence
        elif isinstance(record, SessionEnded):
            ended = record
    damaged = broken_trials(recording.losses, began, over)
    unknown = unknown_trials(recording, began) if recording.losses else {}
    ends = {
        trial: dataclasses.replace(end, complete=end.complete and trial not in damaged)
        for trial, end in ends.items()
        if trial in started
    }
    return Session(
        file=file,
        recording=KnownTrials(recording, frozenset(started)) if unknown else recording,
        opened=opened,
        ended=ended,
        protocol=protocol,
        task=TaskDescription.from_json(opened.task_json),
        trials=started,
        trial_ends=ends,
        damaged_trials=damaged,
        unknown_trials=unknown,
    )


def choose_sessions(
    sessions: Sequence[Session], set_aside: Sequence[SetAside] = (), *, pool: bool = False
) -> StudyRecordings:
    """Keep one session a participant: the first complete one, or else the longest.

    Raises:
        StudyError: there is no session, or ``pool`` is false and protocols differ or people and
            simulated participants are mixed.
    """
    hashes = {session.opened.protocol_sha256 for session in sessions}
    if len(hashes) > 1 and not pool:
        by_protocol = _files_by_protocol(sessions)
        raise StudyError(
            f"these recordings follow {len(hashes)} different protocols:\n"
            + protocols_in_words(by_protocol),
            how_to_choose(by_protocol),
        )
    kinds = {session.opened.operator_kind for session in sessions}
    if len(kinds) > 1 and not pool:
        raise StudyError(
            f"these recordings are of {' and '.join(sorted(map(_kind_in_words, kinds)))}",
            "Give the recordings of one kind, or pool them on purpose with --pool-protocols.",
        )
    aside = list(set_aside)
    by_participant: dict[str, list[Session]] = {}
    for session in sessions:
        by_participant.setdefault(session.opened.participant, []).append(session)
    chosen: list[Session] = []
    for participant, candidates in sorted(by_participant.items()):
        ranked = sorted(candidates, key=_preference)
        chosen.append(ranked[0])
        aside += [
            SetAside(
                other.file,
                participant,
                beside(other.opened, ranked[0].opened, ranked[0].file),
                other.opened.started_utc,
            )
            for other in ranked[1:]
        ]
    if not chosen:
        reasons = "\n  ".join(f"{item.file}: {item.reason}" for item in aside)
        raise StudyError(f"none of the recordings can be used:\n  {reasons}")
    aside.sort(key=lambda item: (item.file, item.reason))
    return StudyRecordings(tuple(chosen), tuple(aside))


def operator_parameters(session: Session) -> dict[str, Any]:
    """Return the simulated operator's recorded parameters; empty for a person."""
    try:
        parsed = json.loads(session.opened.operator_json or "{}")
    except (ValueError, RecursionError):
        return {"unreadable": session.opened.operator_json}
    return parsed if isinstance(parsed, dict) else {"value": parsed}


def timestep_blocks(session: Session) -> list[dict[str, npt.NDArray[Any]]]:
    """Return the timesteps of a session as arrays, in blocks with a constant number of robots.

    Fields have shapes (rows,), (rows, n) and (rows, n, d).
    """
    blocks = session.recording.columns("event/timestep")
    return [block for block in blocks if np.asarray(block["t_ns"]).size]


def _preference(session: Session) -> tuple[bool, int, str, str]:
    opened = session.opened
    length = 0 if session.complete else -len(session.trial_ends)
    return (not session.complete, length, opened.started_utc, session.file)


def _kind_in_words(kind: str) -> str:
    return "simulated participants" if kind == "simulated" else "persons"


def _files_by_protocol(sessions: Sequence[Session]) -> dict[tuple[str, str], list[Path]]:
    """Return the first file of each session, by its protocol's SHA-256 and its study's name."""
    files: dict[tuple[str, str], list[Path]] = {}
    for session in sessions:
        study = session.protocol.get("study", {}).get("name", "")
        path = session.parts[0].path if session.parts else Path(session.file)
        files.setdefault((session.opened.protocol_sha256, study), []).append(path)
    return files
