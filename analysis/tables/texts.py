"""One row for each free answer: what a participant typed."""

from __future__ import annotations

from analysis.recordings import StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from study.events.participant_events import TextAnswered

COLUMNS = (
    *SESSION_COLUMNS,
    Column("phase", "integer", "phase, 1 to 4"),
    Column("block", "integer", "number of the block within its phase, from 1"),
    Column("condition", "label", "name of the condition"),
    Column("questionnaire", "label", "name of the questionnaire"),
    Column("item", "label", "id of the item"),
    Column("occasion", "label", "when it was asked"),
    Column("text", "text", "the answer as typed; empty if the item was left open"),
    Column("latency", "number", "from the screen's entry to the last change", unit="s"),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [
        {
            "participant": session.opened.participant,
            "session": session.opened.session_id,
            "phase": event.phase,
            "block": event.block,
            "condition": event.condition,
            "questionnaire": event.questionnaire,
            "item": event.item,
            "occasion": event.occasion,
            "text": event.text,
            "latency": event.latency_ns / 1e9,
        }
        for session in study.sessions
        for _, event in session.recording.records(TextAnswered.topic)
        if isinstance(event, TextAnswered)
    ]
    return Table.from_rows("texts", "One row a free answer.", COLUMNS, rows)
