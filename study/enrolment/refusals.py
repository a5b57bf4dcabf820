"""Why a participant cannot begin a session, each in one message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from study.enrolment.participants import Participant
from study.enrolment.process_identity import ProcessIdentity
from study.errors import StudyError

Alive = Callable[[ProcessIdentity], bool | None]


def withdrawn(pseudonym: str) -> StudyError:
    """Return the refusal of somebody who withdrew."""
    return StudyError(
        f'participant "{pseudonym}" withdrew, and the data were erased',
        "The pseudonym is not given out again. For another person leave out --participant, and "
        "one is drawn.",
    )


def refuse_another_session(known: Participant, given: str, folder: Path, *, again: bool) -> None:
    """Raise unless a participant whom the register knows may begin a session.

    Raises:
        StudyError: the id is another's but for capitals, or the participant withdrew, is
            excluded, or had a session and ``again`` is false.
    """
    if given != known.pseudonym:
        raise StudyError(
            f'participant "{given}" differs from "{known.pseudonym}" in capital letters only',
            f"Give {known.pseudonym} if that person is meant, or else another id.",
        )
    if known.state == "withdrawn":
        raise withdrawn(given)
    if known.state == "excluded":
        raise StudyError(
            f'participant "{given}" is excluded: {known.reason}',
            f"`study participants restore {given}` takes that back.",
        )
    if known.state == "reserved" or again:
        return
    broken_off = known.state in ("running", "dropped")
    raise StudyError(
        f'participant "{given}" already has a recording in {folder}'
        + (", of a session that is not complete" if broken_off else ""),
        ("To go on where it broke off say --resume. " if broken_off else "")
        + "Give another id, or say --again if this person really takes part once more.",
    )


def refuse_if_conducted(known: Participant, me: ProcessIdentity, alive: Alive) -> None:
    """Raise if a process other than this one runs, or may run, the participant's session.

    Raises:
        StudyError: it does.
    """
    lease = known.lease
    if lease is None or lease == me or known.state not in ("reserved", "running"):
        return
    lives = alive(lease)
    if lives or (lives is None and known.state == "reserved"):
        raise StudyError(
            f'participant "{known.pseudonym}" is in a session: process {lease.pid} on {lease.host}'
            + ("" if lives else ", as far as can be told from here"),
            "End that session first."
            if lives
            else "End that session, or say `study participants release` on that machine.",
        )
