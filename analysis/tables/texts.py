"""One row for each free answer: what a participant typed."""

from __future__ import annotations

from analysis.recordings import StudyRecordings
from analysis.tables.columns import Column, Table
from analysis.tables.responses import ITEM_COLUMNS, LATENCY, item_keys
from study.events.participant_events import TextAnswered

COLUMNS = (
    *ITEM_COLUMNS,
    Column("occasion", "label", "when it was asked"),
    Column("text", "text", "the answer as typed; empty if the item was left open"),
    LATENCY,
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [
        {**item_keys(session, event), "text": event.text}
        for session in study.sessions
        for _, event in session.recording.records(TextAnswered.topic)
        if isinstance(event, TextAnswered)
    ]
    return Table.from_rows("texts", "One row a free answer.", COLUMNS, rows)
