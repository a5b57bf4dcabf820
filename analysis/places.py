"""Whose sessions count in the plan: those who hold a slot, not drop-outs, whose slots go on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from study.recording.enrolled import slots

if TYPE_CHECKING:
    from analysis.recordings import Session

UNKNOWN = -1
"""Slot of a session of which no register tells."""


def with_slots(sessions: Sequence[Session]) -> list[Session]:
    """Return sessions with the slots that registers give their participants now.

    Simulated participants have no place in a register.

    Raises:
        StudyError: a register is there but cannot be read.
    """
    known: dict[Path, dict[tuple[str, str], int]] = {}
    found = []
    for session in sessions:
        slot = UNKNOWN
        if session.parts and session.opened.operator_kind == "person":
            folder = session.parts[0].path.parent
            if folder not in known:
                known[folder] = slots(folder)
            study = session.protocol.get("study", {}).get("name", "")
            slot = known[folder].get((study, session.opened.participant), UNKNOWN)
        found.append(dataclasses.replace(session, slot=slot))
    return found


def holds_slot(session: Session) -> bool:
    """Whether a participant has a place in the plan.

    Where no register tells, it is as in one made from the recordings: who ended early has none.
    """
    if session.slot != UNKNOWN:
        return session.slot > 0
    return session.ended is None or session.ended.complete


def drop_outs(sessions: Sequence[Session]) -> int:
    """Return how many of these sessions are those of drop-outs."""
    return sum(not holds_slot(session) for session in sessions)
