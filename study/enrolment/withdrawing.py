"""Withdrawal: a participant's data are erased; what stays says only that there were some.

The tombstone is durable before the first file goes: whenever this breaks off, saying the same
again finishes it, and analysis leaves the participant out from the first moment.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from study.enrolment.files import files_of
from study.enrolment.not_taking_part import count
from study.enrolment.participants import Participant, now_utc
from study.enrolment.register import Register
from study.errors import StudyError
from study.preflight_result import forget_rehearsed
from study.recording.enrolled import add_tombstone
from study.recording.file_lock import is_held


def withdraw(register: Register, study: str, pseudonym: str) -> list[Path]:
    """Erase a participant's recordings, their parts, copies and exports; leave a tombstone, count.

    Returns:
        The files that were erased.

    Raises:
        StudyError: there is no such participant, a session runs, or a file cannot be erased.
    """
    known = register.find(study, pseudonym)
    if known is None:
        raise StudyError(
            f'no participant "{pseudonym}" of the study {study} in {register.path}',
            "`study participants` lists them.",
        )
    files = to_be_erased(register, known)
    leave_tombstone(register, study, known.pseudonym)
    uncounted: StudyError | None = None
    if known.state != "withdrawn":
        try:
            count(register.folder, study, "erased")
        except StudyError as error:
            # That they are counted matters less than that the data go.
            uncounted = error
    unlink(files, "The rest is noted. Mend that, and say the same again.")
    forget_rehearsed(register.folder, known.pseudonym)
    with register.transaction():
        register.connection.execute(
            "DELETE FROM files WHERE study = ? AND pseudonym = ?", (study, known.pseudonym)
        )
    if uncounted is not None:
        raise uncounted
    return files


def to_be_erased(register: Register, known: Participant) -> list[Path]:
    """Return the files that withdrawing a participant erases.

    Raises:
        StudyError: a session runs, or a file is being written.
    """
    register.refuse_if_conducted(known)
    files = files_of(register, known.study, known.pseudonym)
    for path in files:
        if is_held(path):
            raise StudyError(f"{path} is being written", "End the session first.")
    return files


def unlink(files: Iterable[Path], advice: str) -> None:
    """Erase files, those that are gone already included.

    Args:
        files: in the order in which they go.
        advice: what to do where one cannot be erased.

    Raises:
        StudyError: that is so; the message names it.
    """
    for path in files:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise StudyError(f"{path} could not be erased: {error.strerror}", advice) from error


def leave_tombstone(register: Register, study: str, pseudonym: str) -> None:
    """Keep pseudonym and time of a participant, and nothing else."""
    utc = now_utc()
    with register.transaction():
        # Inside, so that two who withdraw at once do not overwrite one another's.
        add_tombstone(register.folder, study, pseudonym, utc)
        known = register.known(study, pseudonym)
        if known is not None and known.state != "withdrawn":
            register.bury(study, pseudonym, utc)
