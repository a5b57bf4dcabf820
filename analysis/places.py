"""Whose sessions count in the plan: those who hold a slot, not drop-outs, whose slots go on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from analysis.recordings import Session

UNKNOWN = -1
"""Slot of a session of which no register tells."""


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
