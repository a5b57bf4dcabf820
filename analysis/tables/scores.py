"""One row a score: a scale of an instrument, as answered on one occasion."""

from __future__ import annotations

import math
from collections.abc import Iterator

from analysis.instruments import Instrument, instruments
from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from study.events.events import QuestionAnswered
from study.events.participant_events import InstrumentScored

RECORDED, COMPUTED = "recorded", "computed"

COLUMNS = (
    *SESSION_COLUMNS,
    Column("phase", "integer", "phase, 1 to 4; 0 before them"),
    Column("block", "integer", "number of the block within its phase, from 1"),
    Column("condition", "label", "name of the condition; empty if asked outside of one"),
    Column("questionnaire", "label", "name of the instrument"),
    Column("version", "integer", "version of its wording and scoring; 0 if not recorded"),
    Column("scale", "label", "name of the scale within the instrument"),
    Column("occasion", "label", "when it was asked: before_reveal, after_reveal, at_start, at_end"),
    Column("score", "number", "the score"),
    Column("computed", "number", "the same from the answers; missing where an answer is"),
    Column("lowest", "number", "least score possible"),
    Column("highest", "number", "largest score possible"),
    Column("items", "integer", "items that enter"),
    Column("origin", "label", "recorded by the session, or computed from its answers"),
)

Form = tuple[int, int, str, str, str]
"""Phase, block, condition, questionnaire, occasion."""


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings.

    A session scores an instrument when its last page is confirmed, and records that. Recordings
    from before it did are scored from the answers, by the rule that they carry.
    """
    rows = [row for session in study.sessions for row in _rows(session)]
    return Table.from_rows("scores", "One row a score.", COLUMNS, rows)


def answers_by_form(session: Session) -> dict[Form, dict[str, int]]:
    """Return the answers that have a value, by form and item."""
    found: dict[Form, dict[str, int]] = {}
    for _, event in session.recording.records(QuestionAnswered.topic):
        if isinstance(event, QuestionAnswered):
            form = (event.phase, event.block, event.condition, event.questionnaire, event.occasion)
            found.setdefault(form, {})[event.item] = event.value
    return found


def _rows(session: Session) -> Iterator[dict[str, object]]:
    asked, answered = instruments(session), answers_by_form(session)
    scored = [
        event
        for _, event in session.recording.records(InstrumentScored.topic)
        if isinstance(event, InstrumentScored)
    ]
    for event in scored:
        form = (event.phase, event.block, event.condition, event.questionnaire, event.occasion)
        instrument = asked.get(event.questionnaire)
        computed = _computed(instrument, event.scale, answered.get(form, {}))
        yield {
            **_keys(session, form, event.version, event.scale),
            "score": event.score,
            "computed": math.nan if computed is None else computed,
            **_extent(instrument, event.scale),
            "origin": RECORDED,
        }
    if scored:
        return
    for form, answers in answered.items():
        instrument = asked.get(form[3])
        for scale in instrument.scales if instrument else ():
            computed = _computed(instrument, scale.name, answers)
            if instrument is not None and computed is not None:
                yield {
                    **_keys(session, form, instrument.version, scale.name),
                    "score": computed,
                    "computed": computed,
                    **_extent(instrument, scale.name),
                    "origin": COMPUTED,
                }


def _keys(session: Session, form: Form, version: int, scale: str) -> dict[str, object]:
    phase, block, condition, questionnaire, occasion = form
    return {
        "participant": session.opened.participant,
        "session": session.opened.session_id,
        "phase": phase,
        "block": block,
        "condition": condition,
        "questionnaire": questionnaire,
        "version": version,
        "scale": scale,
        "occasion": occasion,
    }


def _computed(instrument: Instrument | None, name: str, answers: dict[str, int]) -> float | None:
    scale = instrument.scale(name) if instrument else None
    return instrument.score(scale, answers) if instrument and scale else None


def _extent(instrument: Instrument | None, name: str) -> dict[str, object]:
    scale = instrument.scale(name) if instrument else None
    if instrument is None or scale is None:
        return {"lowest": math.nan, "highest": math.nan, "items": 0}
    low, high = instrument.reach(scale)
    return {"lowest": low, "highest": high, "items": len(scale.items)}
