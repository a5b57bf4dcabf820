"""One row for each note that the experimenter took during a session."""

from __future__ import annotations

from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys
from study.events.events import StageEntered
from study.events.experimenter_records import ExperimenterNoted

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("t", "number", "time since the session opened", unit="s"),
    Column("stage", "label", "name of the stage in which it was taken"),
    Column("kept", "boolean", "false if a resumed session began anew before it"),
    Column("text", "text", "the note"),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [row for session in study.sessions for row in _rows(session)]
    text = "One row a note of the experimenter; trial_id is -1 outside a fleet run"
    return Table.from_rows("notes", text, COLUMNS, rows)


def _rows(session: Session) -> list[dict[str, object]]:
    found: list[dict[str, object]] = []
    stage = ""
    topics = (StageEntered.topic, ExperimenterNoted.topic)
    for record, kept in session.recording.every_record(*topics):
        if isinstance(record, StageEntered):
            stage = record.name
        elif isinstance(record, ExperimenterNoted):
            row = {"t": record.t_ns / 1e9, "stage": stage, "kept": kept, "text": record.text}
            found.append({**trial_keys(session, record.trial_id), **row})
    return found
