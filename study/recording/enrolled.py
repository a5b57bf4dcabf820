"""What lies beside recordings and says whose are not to be analysed.

The register of participants is written by `study.enrolment`; here it is only read, as analysis
does. Tombstones of those who withdrew lie in a text file of their own, so that they outlive the
register.
"""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path

from study.errors import StudyError
from study.whole_file import replace_text

FILE_NAME = "participants.sqlite"
TOMBSTONES = "withdrawn.json"
APPLICATION_ID = 0x53415031
"""Stamps the register as ours: "SAP1"."""
VERSION = 1
_LIMIT = 16 << 20


def tombstones(folder: Path) -> dict[str, dict[str, str]]:
    """Return who withdrew: study to pseudonym to the time, ISO 8601.

    Raises:
        StudyError: the file is there but holds something else.
    """
    path = folder / TOMBSTONES
    try:
        with path.open(encoding="utf-8") as stream:
            found = json.loads(stream.read(_LIMIT))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict) or not all(
        isinstance(of_study, dict) and all(isinstance(utc, str) for utc in of_study.values())
        for of_study in found.values()
    ):
        raise StudyError(
            f"{path} is no list of those who withdrew",
            "It is needed to keep their data out. Mend it, or put a copy of it there.",
        )
    return found


def add_tombstone(folder: Path, study: str, pseudonym: str, utc: str) -> None:
    """Note, durably, that a participant withdrew; an earlier time stays.

    Raises:
        StudyError: it cannot be noted.
    """
    found = tombstones(folder)
    found.setdefault(study, {}).setdefault(pseudonym, utc)
    path = folder / TOMBSTONES
    try:
        replace_text(path, json.dumps(found, indent=2, sort_keys=True) + "\n", private=True)
    except OSError as error:
        raise StudyError(f"{path} cannot be written: {error.strerror}") from error


def not_analysed(folder: Path) -> dict[tuple[str, str], str]:
    """Return (study, pseudonym) to why that participant's recordings here are left out.

    Raises:
        StudyError: tombstones or register cannot be read.
    """
    found = dict(_marked(folder / FILE_NAME))
    for study, of_study in tombstones(folder).items():
        for pseudonym in of_study:
            found[study, pseudonym] = "the participant withdrew"
    return found


def _marked(path: Path) -> list[tuple[tuple[str, str], str]]:
    if not path.is_file() or not path.stat().st_size:
        return []
    query = "SELECT study, pseudonym, state, reason, pilot FROM participants"
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as register:
            if register.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
                return []
            rows = register.execute(query).fetchall()
    except sqlite3.Error as error:
        raise StudyError(
            f"the register {path} cannot be read: {error}",
            "It says who is not to be analysed. Mend it, or move it away to do without.",
        ) from error
    return [
        ((study, pseudonym), f"excluded by the experimenter: {reason}")
        if state == "excluded"
        else ((study, pseudonym), "a pilot session")
        for study, pseudonym, state, reason, pilot in rows
        if state == "excluded" or pilot
    ]
