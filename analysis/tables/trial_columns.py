"""The columns that place a record of a fleet run."""

from __future__ import annotations

from analysis.recordings import Session
from analysis.tables.columns import Column

TRIAL_COLUMNS = (
    Column("trial_id", "integer", "number of the fleet run in the session, from 0"),
    Column("phase", "integer", "phase, 1 to 4; 0 is practice"),
    Column("block", "integer", "number of the block within its phase, from 1"),
    Column("condition", "label", "name of the condition; empty outside phases three and four"),
    Column("trial", "integer", "number within the block, from 1"),
)
"""What tells one fleet run from another; every table below the session has them."""


def trial_keys(session: Session, trial_id: int) -> dict[str, object]:
    """Return the columns that place a record of a fleet run."""
    trial = session.trials.get(trial_id)
    return {
        "participant": session.opened.participant,
        "session": session.opened.session_id,
        "trial_id": trial_id,
        "phase": trial.phase if trial else 0,
        "block": trial.block if trial else 0,
        "condition": trial.condition if trial else "",
        "trial": trial.trial if trial else 0,
    }
