"""Bringing a register in step with the recordings of its folder; from nothing, if need be."""

from __future__ import annotations

import contextlib
import dataclasses
from pathlib import Path

from study.enrolment.participants import Participant, State
from study.enrolment.pseudonyms import PARTICIPANT
from study.enrolment.register import Register
from study.enrolment.withdrawing import withdraw
from study.errors import StudyError
from study.events.events import SessionEnded
from study.events.inputs import SessionOpened
from study.protocol import parse_protocol
from study.recording.enrolled import tombstones
from study.recording.identity import PILOT
from study.recording.parts import SessionRecording, base_name, read_session
from study.recording.register_folders import recordings_under, register_folder

NOT_UNDERSTOOD = "the instructions were not understood"
"""Reason of a session that ended because the comprehension check was failed."""
ERASED = "erased by the participant"
"""Reason of a session that ended because the participant wants all data erased."""


@dataclasses.dataclass(frozen=True, slots=True)
class _Found:
    """A session that a recording tells of."""

    participant: Participant
    started_utc: str
    files: tuple[str, ...]


def outcome_of(ended: SessionEnded | None) -> tuple[State, str]:
    """Return the state, and the reason in words, that a session came to by its last event."""
    if ended is None:
        return "running", ""
    if ended.complete:
        return "complete", ""
    return ("excluded" if ended.reason == NOT_UNDERSTOOD else "dropped"), ended.reason


def bring_in_step(register: Register) -> int:
    """Take in recordings that the register does not know, and tombstones.

    A register that has just been made is thereby built anew. Recordings of simulated
    participants and of other programs are passed over.

    Returns:
        How many participants were added.

    Raises:
        StudyError: register or tombstones cannot be used.
    """
    folder = register.folder
    added = _take_in_tombstones(register)
    with register.transaction():
        known = {row[0] for row in register.connection.execute("SELECT path FROM files")}
    fresh: dict[str, Path] = {}
    for path in recordings_under(folder):
        if _final_name(path, folder) not in known:
            fresh.setdefault(str(path.parent / base_name(path)), path)
    others: list[str] = []
    found: list[_Found] = []
    for path in fresh.values():
        try:
            session = _session(read_session(path), folder)
        except StudyError:
            # Perhaps a part beside it has only just been made: it is looked at again next time.
            continue
        if session:
            found.append(session)
        elif path.suffix == ".mcap":
            others.append(_final_name(path, folder))
    with register.transaction():
        for name in others:
            _know(register, name)
        for session in sorted(found, key=lambda item: item.started_utc):
            added += _take_in(register, session)
    for session in found:
        if session.participant.reason == ERASED:
            _erase(register, session.participant)
    return added


def _erase(register: Register, asked: Participant) -> None:
    """Do what a participant asked for in a session whose process was gone before it could."""
    # While that process lives, or a file is held, it does so itself: it is looked at again.
    with contextlib.suppress(StudyError):
        withdraw(register, asked.study, asked.pseudonym)


def _session(recording: SessionRecording, folder: Path) -> _Found | None:
    """Return what a recording tells of a person's session; None if it is none."""
    opened, ended = None, None
    for _, record in recording.records(SessionOpened.topic, SessionEnded.topic):
        if isinstance(record, SessionOpened):
            opened = record
        elif isinstance(record, SessionEnded):
            ended = record
    if opened is None or opened.operator_kind != "person":
        return None
    if not PARTICIPANT.fullmatch(opened.participant):
        return None
    state, reason = outcome_of(ended)
    study = parse_protocol(opened.protocol_toml, "the recorded protocol").study.name
    participant = Participant(
        study=study,
        pseudonym=opened.participant,
        state=state,
        slot=0,
        order=opened.order,
        pilot=recording.metadata.get(PILOT) == "true",
        reason=reason,
        changed_utc=opened.started_utc,
    )
    files = tuple(_final_name(part.path, folder) for part in recording.parts)
    return _Found(participant, opened.started_utc, files)


def _take_in(register: Register, found: _Found) -> int:
    """Add a session's participant, or correct a state that a killed session left behind."""
    given = found.participant
    known = register.known(given.study, given.pseudonym)
    if known is None:
        register.insert(given)
    elif known.state == "withdrawn":
        pass
    elif known.interrupted and given.state != "running":
        register.change(given.study, given.pseudonym, given.state, given.reason)
    elif known.state == "reserved" and known.visits == 1:
        # Its process wrote the file and has not yet said so, or died before it could.
        register.change(given.study, given.pseudonym, given.state, given.reason)
    elif known.state == "dropped" and given.state == "complete":
        register.change(given.study, given.pseudonym, "complete", given.reason)
    for name in found.files:
        # Of a session that has not ended the outcome may still have to be read.
        if given.state != "running" and given.reason != ERASED:
            _know(register, name, given.study, given.pseudonym)
    return int(known is None)


def _take_in_tombstones(register: Register) -> int:
    """Put who withdrew into a register that does not know it."""
    added = 0
    listed = tombstones(register.folder)
    with register.transaction():
        for study, of_study in listed.items():
            for pseudonym, utc in of_study.items():
                known = register.known(study, pseudonym)
                if known is None:
                    register.insert(
                        Participant(study, pseudonym, "withdrawn", 0, (), changed_utc=utc)
                    )
                    added += 1
                elif known.state != "withdrawn":
                    register.bury(study, pseudonym, utc)
    return added


def note_export(recording: Path, exported: Path) -> None:
    """Note a file made from one recording, so that withdrawal erases it too.

    Nothing is noted where no register speaks for the recording, or it is of no person. A file in
    the register's folder is noted by its path from there, so that a copy of the folder has its own.

    Raises:
        StudyError: the register cannot be used.
    """
    folder = register_folder(recording.parent)
    if folder is None:
        return
    found = _session(read_session(recording.absolute()), folder)
    if found is None:
        return
    path = exported.absolute()
    with contextlib.suppress(ValueError):
        path = path.relative_to(folder)
    with Register(folder) as register, register.transaction():
        whose = found.participant
        _know(register, str(path), whose.study, whose.pseudonym)


def _know(register: Register, path: str, study: str = "", pseudonym: str = "") -> None:
    register.connection.execute(
        "INSERT OR REPLACE INTO files (path, study, pseudonym) VALUES (?, ?, ?)",
        (path, study, pseudonym),
    )


def _final_name(path: Path, folder: Path) -> str:
    """Return a file's path from the register's folder, as it is called once it is closed."""
    return str(path.relative_to(folder)).removesuffix(".part")
