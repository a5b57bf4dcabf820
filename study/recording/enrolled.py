"""What lies beside recordings and says whose are not to be analysed, and what order the plan had.

The register of participants is written by `study.enrolment`; here it is only read, as analysis
does. Tombstones of those who withdrew lie in a text file of their own, so that they outlive the
register.
"""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from study.errors import StudyError
from study.recording.register_folders import FILE_NAME, and_above, register_folder
from study.whole_file import replace_text

TOMBSTONES = "withdrawn.json"
APPLICATION_ID = 0x53415031
"""Stamps the register as ours: "SAP1"."""
VERSION = 1
PLAN_HAD = "by hand; the plan had "
"""In the history of who got an order by hand; what follows is the plan's, by commas."""
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
    """Return (study, pseudonym) to why that participant's recordings in a folder are left out.

    The register that speaks for the folder is asked, and the tombstones of all folders above it:
    who withdrew there is not analysed, whatever register lies between.

    Raises:
        StudyError: tombstones or register cannot be read.
    """
    found = dict(_marked(folder))
    for place in and_above(folder):
        for study, of_study in tombstones(place).items():
            for pseudonym in of_study:
                found[study, pseudonym] = "the participant withdrew"
    return found


def _marked(folder: Path) -> list[tuple[tuple[str, str], str]]:
    query = "SELECT study, pseudonym, state, reason, pilot FROM participants"
    return [
        ((study, pseudonym), f"excluded by the experimenter: {reason}")
        if state == "excluded"
        else ((study, pseudonym), "a pilot session")
        for study, pseudonym, state, reason, pilot in _rows(folder, query)
        if state == "excluded" or pilot
    ]


def planned_orders(folder: Path) -> dict[tuple[str, str], tuple[str, ...]]:
    """Return (study, pseudonym) to the order that the plan had for that participant.

    Of a register made anew from recordings it is the order that they say was run.

    Raises:
        StudyError: the register cannot be read.
    """
    query = (
        "SELECT participants.study, participants.pseudonym, run_order, detail FROM participants "
        "LEFT JOIN history ON history.study = participants.study "
        "AND history.pseudonym = participants.pseudonym AND what = 'reserved' "
        "AND instr(detail, ?) ORDER BY number DESC"
    )
    # The first of a participant's lines counts: it is read last.
    return {
        (study, pseudonym): tuple((detail.partition(PLAN_HAD)[2] if detail else run).split(","))
        for study, pseudonym, run, detail in _rows(folder, query, PLAN_HAD)
        if run
    }


def _rows(folder: Path, query: str, *values: str) -> list[tuple[Any, ...]]:
    """Ask the register that speaks for a folder; nothing is answered where there is none."""
    place = register_folder(folder)
    if place is None:
        return []
    path = place / FILE_NAME
    if not path.is_file() or not path.stat().st_size:
        return []
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as register:
            if register.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
                return []
            return register.execute(query, values).fetchall()
    except sqlite3.Error as error:
        raise StudyError(
            f"the register {path} cannot be read: {error}",
            "It says who is not to be analysed. Mend it, or move it away to do without.",
        ) from error


_HOLDING = ("reserved", "running", "complete")
"""States that hold a slot; the same as `study.enrolment.participants.HOLDING`."""


def slots(folder: Path) -> dict[tuple[str, str], int]:
    """Return (study, pseudonym) to the slot that a participant holds, from 1; 0 for none.

    Raises:
        StudyError: the register cannot be read.
    """
    query = "SELECT study, pseudonym, state, slot FROM participants"
    return {
        (study, pseudonym): slot if state in _HOLDING else 0
        for study, pseudonym, state, slot in _rows(folder, query)
    }
