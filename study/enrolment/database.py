"""The register's file: SQLite, private, and one clear message whatever is wrong with it.

A rollback journal, not a write-ahead log: transactions are few and tiny, and one file without
companions can be copied, read in a folder that cannot be written, and lie on a network drive.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from study.errors import StudyError
from study.recording.enrolled import APPLICATION_ID, VERSION
from study.recording.register_folders import FILE_NAME

PATIENCE_S = 30.0
"""How long another process's transaction is waited for; one takes some milliseconds."""

_SCHEMA = """
CREATE TABLE participants (
    study TEXT NOT NULL,
    pseudonym TEXT NOT NULL COLLATE NOCASE,
    state TEXT NOT NULL CHECK (state IN
        ('reserved', 'running', 'complete', 'dropped', 'excluded', 'withdrawn')),
    slot INTEGER NOT NULL,
    run_order TEXT NOT NULL,
    pilot INTEGER NOT NULL CHECK (pilot IN (0, 1)),
    visits INTEGER NOT NULL DEFAULT 1,
    reason TEXT NOT NULL DEFAULT '',
    note TEXT NOT NULL DEFAULT '',
    changed_utc TEXT NOT NULL,
    before_edit TEXT NOT NULL DEFAULT '',
    host TEXT, pid INTEGER, started TEXT,
    PRIMARY KEY (study, pseudonym)
);
CREATE UNIQUE INDEX one_holder_a_slot ON participants (study, pilot, slot)
    WHERE state IN ('reserved', 'running', 'complete');
CREATE TABLE history (
    number INTEGER PRIMARY KEY,
    study TEXT NOT NULL,
    pseudonym TEXT NOT NULL COLLATE NOCASE,
    utc TEXT NOT NULL,
    what TEXT NOT NULL,
    detail TEXT NOT NULL
);
CREATE TABLE files (
    path TEXT PRIMARY KEY,
    study TEXT NOT NULL DEFAULT '',
    pseudonym TEXT NOT NULL DEFAULT '' COLLATE NOCASE
);
"""


def open_database(folder: Path, *, patience_s: float = PATIENCE_S) -> sqlite3.Connection:
    """Open a folder's register; make both, for their owner only, if need be.

    Raises:
        StudyError: it cannot be made or opened, is none, or is newer than this program.
    """
    path = folder / FILE_NAME
    with explained(path):
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            with suppress(FileExistsError):
                os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        except OSError as error:
            raise StudyError(
                f"the register {path} cannot be made: {error.strerror}",
                "Choose another folder for recordings, or make that one writable.",
            ) from error
        connection = sqlite3.connect(path, timeout=patience_s, isolation_level=None)
        try:
            _prepare(connection, path)
        except BaseException:
            connection.close()
            raise
    return connection


def _prepare(connection: sqlite3.Connection, path: Path) -> None:
    """Make the tables where there are none; refuse what is not ours."""
    # What is erased is overwritten, not only forgotten.
    connection.execute("PRAGMA secure_delete = ON")
    connection.execute("PRAGMA synchronous = FULL")
    if _stamp(connection) == (APPLICATION_ID, VERSION):
        return
    with transaction(connection, path):
        application, version = _stamp(connection)
        tables = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
        if application == 0 and version == 0 and tables == 0:
            for statement in _SCHEMA.split(";\n"):
                if statement.strip():
                    connection.execute(statement)
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            connection.execute(f"PRAGMA user_version = {VERSION}")
        elif application != APPLICATION_ID:
            raise StudyError(
                f"{path} is a database of another program",
                "Move it away, or give another folder of recordings.",
            )
        elif version != VERSION:
            raise StudyError(
                f"{path} has version {version}; this program knows {VERSION}",
                "Use the newer version of the program.",
            )


def _stamp(connection: sqlite3.Connection) -> tuple[int, int]:
    return (
        connection.execute("PRAGMA application_id").fetchone()[0],
        connection.execute("PRAGMA user_version").fetchone()[0],
    )


@contextmanager
def transaction(connection: sqlite3.Connection, path: Path) -> Iterator[None]:
    """All or nothing, with nobody else in between.

    Raises:
        StudyError: see `explained`.
    """
    with explained(path):
        connection.execute("BEGIN IMMEDIATE")
        try:
            yield
            connection.execute("COMMIT")
        except BaseException:
            with suppress(sqlite3.Error):
                connection.execute("ROLLBACK")
            raise


@contextmanager
def explained(path: Path) -> Iterator[None]:
    """Turn what SQLite reports into one message.

    Raises:
        StudyError: the file is damaged, locked, cannot be read or written, or the disk is full.
    """
    try:
        yield
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorcode", 0) & 0xFF
        what, hint = _MESSAGES.get(code, (f"cannot be used: {error}", "Look after its folder."))
        raise StudyError(f"the register {path} {what}", hint) from error


_ANEW = (
    "Move it away; `study participants` on its folder makes it anew from the recordings there, "
    "without notes and marks made by hand."
)
_MESSAGES = {
    sqlite3.SQLITE_NOTADB: ("is no register of participants, or is damaged", _ANEW),
    sqlite3.SQLITE_CORRUPT: ("is damaged", _ANEW),
    sqlite3.SQLITE_ERROR: ("is no register of participants, or is damaged", _ANEW),
    sqlite3.SQLITE_BUSY: (
        "is locked by another program",
        "Close what has it open, a database browser perhaps, and say the same again.",
    ),
    sqlite3.SQLITE_READONLY: (
        "cannot be written",
        "Make it and its folder writable, or choose another folder for recordings.",
    ),
    sqlite3.SQLITE_CANTOPEN: (
        "cannot be opened",
        "Make it and its folder readable and writable, or choose another folder.",
    ),
    sqlite3.SQLITE_FULL: (
        "cannot be written: the disk is full",
        "Make room; nothing was changed.",
    ),
    sqlite3.SQLITE_IOERR: (
        "cannot be read or written: input/output error, or the disk is full",
        "Look after the disk; nothing was changed.",
    ),
}
