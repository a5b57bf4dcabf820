"""Participants as rows of the register."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from study.enrolment.participants import Participant
from study.enrolment.process_identity import ProcessIdentity

COLUMNS = (
    "study, pseudonym, state, slot, run_order, pilot, visits, reason, note, changed_utc, "
    "host, pid, started"
)


def participant_of(
    row: tuple[Any, ...], alive: Callable[[ProcessIdentity], bool | None]
) -> Participant:
    """Return a row of `COLUMNS` as a participant, with what can be told of its process."""
    study, pseudonym, state, slot, order, pilot, visits, reason, note, utc, *process = row
    lease = ProcessIdentity(*process) if process[1] is not None else None
    gone = lease is None or alive(lease) is False
    return Participant(
        study=study,
        pseudonym=pseudonym,
        state=state,
        slot=slot,
        order=split_order(order),
        pilot=bool(pilot),
        visits=visits,
        # Of a session that has not begun there is none: the row keeps that of the one before.
        reason="" if state == "reserved" else reason,
        note=note,
        changed_utc=utc,
        lease=lease,
        interrupted=state == "running" and gone,
    )


def split_order(text: str) -> tuple[str, ...]:
    """Return the conditions of an order as it is stored."""
    return tuple(name for name in text.split(",") if name)
