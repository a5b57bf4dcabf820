"""One row an answer to one item of a questionnaire."""

from __future__ import annotations

from analysis.recordings import StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from study.events.events import QuestionAnswered

COLUMNS = (
    *SESSION_COLUMNS,
    Column("phase", "integer", "phase, 1 to 4"),
    Column("block", "integer", "number of the block within its phase, from 1"),
    Column("condition", "label", "name of the condition"),
    Column("questionnaire", "label", "name of the questionnaire"),
    Column("item", "label", "id of the item"),
    Column("occasion", "label", "before_reveal or after_reveal"),
    Column("answer", "integer", "the answer"),
    Column("latency", "number", "from the screen's entry to the last change", unit="s"),
    Column("changes", "integer", "how often the answer was changed before confirmation"),
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
            "answer": event.value,
            "latency": event.latency_ns / 1e9,
            "changes": event.changes,
        }
        for session in study.sessions
        for _, event in session.recording.records(QuestionAnswered.topic)
        if isinstance(event, QuestionAnswered)
    ]
    return Table.from_rows("responses", "One row an answer.", COLUMNS, rows)
