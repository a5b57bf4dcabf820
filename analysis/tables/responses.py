"""One row an answer to one item of a questionnaire."""

from __future__ import annotations

from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from study.events.events import QuestionAnswered
from study.events.participant_events import TextAnswered

ITEM_COLUMNS = (
    *SESSION_COLUMNS,
    Column("phase", "integer", "phase, 1 to 4"),
    Column("block", "integer", "number of the block within its phase, from 1"),
    Column("condition", "label", "name of the condition"),
    Column("questionnaire", "label", "name of the questionnaire"),
    Column("item", "label", "id of the item"),
)
"""Which item was answered, where; see `item_keys`."""

LATENCY = Column("latency", "number", "from the screen's entry to the last change", unit="s")

COLUMNS = (
    *ITEM_COLUMNS,
    Column("occasion", "label", "before_reveal or after_reveal"),
    Column("answer", "integer", "the answer"),
    LATENCY,
    Column("changes", "integer", "how often the answer was changed before confirmation"),
)


def item_keys(session: Session, event: QuestionAnswered | TextAnswered) -> dict[str, object]:
    """Return what a row says of an answer, whatever kind it is: item, place, occasion, latency."""
    return {
        "participant": session.opened.participant,
        "session": session.opened.session_id,
        "phase": event.phase,
        "block": event.block,
        "condition": event.condition,
        "questionnaire": event.questionnaire,
        "item": event.item,
        "occasion": event.occasion,
        "latency": event.latency_ns / 1e9,
    }


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [
        {**item_keys(session, event), "answer": event.value, "changes": event.changes}
        for session in study.sessions
        for _, event in session.recording.records(QuestionAnswered.topic)
        if isinstance(event, QuestionAnswered)
    ]
    return Table.from_rows("responses", "One row an answer.", COLUMNS, rows)
