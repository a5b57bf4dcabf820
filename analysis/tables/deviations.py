"""One row for each thing that did not go as the protocol says."""

from __future__ import annotations

from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trials import TRIAL_COLUMNS, trial_keys
from study.events.events import Deviation, Resumed

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("t", "number", "time since the session opened", unit="s"),
    Column("code", "label", "what kind it is"),
    Column("text", "text", "what happened, in words"),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings; pauses are listed too, as "paused"."""
    rows = [row for session in study.sessions for row in _rows(session)]
    text = "One row a deviation from the protocol; trial_id is -1 outside a fleet run."
    return Table.from_rows("deviations", text, COLUMNS, rows)


def _rows(session: Session) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for _, event in session.recording.records(Deviation.topic, Resumed.topic):
        if isinstance(event, Deviation):
            trial_id, code, text = event.trial_id, event.code, event.text
        elif isinstance(event, Resumed):
            trial_id, code = -1, "paused"
            text = f"Stood still for {event.paused_ns / 1e9:.1f} s"
        else:
            continue
        keys = trial_keys(session, trial_id)
        rows.append({**keys, "t": event.t_ns / 1e9, "code": code, "text": text})
    return rows
