"""Which files of a folder hold a participant's data."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from study.enrolment.register import Register
from study.errors import StudyError
from study.protocol import parse_protocol
from study.recording.exported import export_of
from study.recording.reader import read_recording
from study.recording.register_folders import under


def files_of(register: Register, study: str, pseudonym: str) -> list[Path]:
    """Return the files that hold a participant's data: those noted, and all found by looking.

    Looked through are the register's folder and those under it that have no register of their
    own. A file there is the participant's by its metadata, or, where it cannot be read, by the
    name that a session gave it: parts, unfinished files, salvaged copies and exports too. A video
    that was noted and moved within these folders is found by its name.
    """
    folder = register.folder
    with register.transaction():
        rows = register.connection.execute("SELECT path, study, pseudonym FROM files").fetchall()
    noted = {folder / row[0]: (row[1], row[2]) == (study, pseudonym) for row in rows}
    found = {path for path, is_theirs in noted.items() if is_theirs}
    # A video says nothing of whose it is: one that was moved is known by its name.
    moved = {path.name for path in found if not path.is_file()}
    found.update(
        path
        for path in under(folder, moved).files
        if _is_of(path, study, pseudonym) or (path.name in moved and noted.get(path, True))
    )
    return sorted(path for path in found if path.is_file())


def out_of_reach(register: Register, study: str, pseudonym: str) -> list[str]:
    """Say, a sentence each, where data of a participant are or may be that the register misses."""
    seen = under(register.folder)
    told = [f"{place} cannot be looked into." for place in seen.unseen]
    for place in seen.registers:
        there = [path for path in place.rglob("*.mcap*") if _is_of(path, study, pseudonym)]
        if there:
            told.append(
                f"{place} has a register of its own, and {files_in_words(there)} of {pseudonym}. "
                f"Say `study participants withdraw {pseudonym} {place}` too."
            )
    return told


def files_in_words(files: Sequence[Path]) -> str:
    """Return how many files there are and what they are called."""
    if not files:
        return "there was no file"
    names = ", ".join(path.name for path in files)
    return f"{len(files)} file{'s' * (len(files) != 1)}, {names}"


def _is_of(path: Path, study: str, pseudonym: str) -> bool:
    """Whether a file is a recording of the participant in the study, or an export of one."""
    begins = rf"{re.escape(study)}_{re.escape(pseudonym)}_\d{{8}}T\d{{6}}_"
    if export := export_of(path):
        if export.participant:
            return (export.study, export.participant) == (study, pseudonym)
        return any(re.match(begins, name) for name in export.files)
    try:
        recording = read_recording(path)
        if whose := recording.metadata.get("participant"):
            toml = recording.attachments.get("protocol.toml", b"").decode()
            return whose == pseudonym and parse_protocol(toml, path.name).study.name == study
    except (StudyError, UnicodeDecodeError):
        pass
    # The time in it tells P01 from P01_b, whose data must not be erased with those of P01.
    return re.match(begins, path.name) is not None
