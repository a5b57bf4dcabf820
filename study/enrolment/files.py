"""Which files of a folder hold a participant's data."""

from __future__ import annotations

import re
from pathlib import Path

from study.enrolment.register import Register
from study.errors import StudyError
from study.protocol import parse_protocol
from study.recording.reader import read_recording


def files_of(register: Register, study: str, pseudonym: str) -> list[Path]:
    """Return the files that hold a participant's data: those noted, and all found in the folder.

    A file in the folder is the participant's by its metadata, or, where it cannot be read, by the
    name that a session gave it: parts, unfinished files and salvaged copies too.
    """
    folder = register.folder
    with register.transaction():
        rows = register.connection.execute(
            "SELECT path FROM files WHERE study = ? AND pseudonym = ?", (study, pseudonym)
        ).fetchall()
    found = {folder / row[0] for row in rows}
    for path in folder.glob("*.mcap*"):
        if _is_of(path, study, pseudonym):
            found.add(path)
    return sorted(path for path in found if path.is_file())


def _is_of(path: Path, study: str, pseudonym: str) -> bool:
    """Whether a file is a recording of the participant in the study."""
    try:
        recording = read_recording(path)
        if whose := recording.metadata.get("participant"):
            toml = recording.attachments.get("protocol.toml", b"").decode()
            return whose == pseudonym and parse_protocol(toml, path.name).study.name == study
    except (StudyError, UnicodeDecodeError):
        pass
    # The time in it tells P01 from P01_b, whose data must not be erased with those of P01.
    begins = rf"{re.escape(study)}_{re.escape(pseudonym)}_\d{{8}}T\d{{6}}_"
    return re.match(begins, path.name) is not None
