"""One row for each thing that did not go as the protocol says."""

from __future__ import annotations

from typing import Final

from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys
from study.events.events import (
    Deviation,
    Paused,
    Resumed,
    StageEntered,
    TrialEnded,
    TrialStarted,
)
from study.events.inputs import RecordingRestored, SessionResumed

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("t", "number", "time since the session opened", unit="s"),
    Column("part", "integer", "part of the recording that was being written, from 1"),
    Column("kept", "boolean", "false if a resumed session began anew before it"),
    Column("code", "label", "what kind it is"),
    Column("text", "text", "what happened, in words"),
)

_TOPICS: Final = (
    TrialStarted.topic,
    TrialEnded.topic,
    StageEntered.topic,
    Paused.topic,
    Resumed.topic,
    Deviation.topic,
    SessionResumed.topic,
    RecordingRestored.topic,
)


_WHO: Final = {"operator": "participant"}
"""Reasons of a pause that are recorded as one word and are another everywhere else."""


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings; pauses are listed too, as "paused"."""
    rows = [row for session in study.sessions for row in session_rows(session)]
    text = (
        "One row a deviation from the protocol; trial_id is -1 outside a fleet run. That of a "
        '"resumed" session is the fleet run begun anew, if one had been broken off.'
    )
    return Table.from_rows("deviations", text, COLUMNS, rows)


def session_rows(session: Session) -> list[dict[str, object]]:
    """Return the deviations of one session, in order, as rows of the table.

    What a resumed session began anew before is among them: that it was ended, and why, is told.
    """
    found: list[dict[str, object]] = []
    part, running, paused_in, why = 1, -1, -1, ""
    anew: dict[str, object] | None = None
    """The row of a resume whose stage has not shown yet whether a fleet run begins anew."""
    for record, kept in session.recording.every_record(*_TOPICS):
        if isinstance(record, SessionResumed | RecordingRestored):
            part = record.part
        elif isinstance(record, TrialStarted):
            running = record.trial_id
            if anew is not None:
                anew["trial_id"], anew = running, None
        elif isinstance(record, TrialEnded):
            running = -1
        elif isinstance(record, StageEntered):
            if record.kind != "trial":
                anew = None
        elif isinstance(record, Paused):
            paused_in, why = running, record.reason
        elif isinstance(record, Resumed):
            text = f"Stood still for {record.paused_ns / 1e9:.1f} s: {_WHO.get(why, why)}"
            row = {"trial_id": paused_in, "code": "paused", "text": text}
            found.append({"t": record.t_ns / 1e9, "part": part, "kept": kept, **row})
        elif isinstance(record, Deviation):
            row = {"trial_id": record.trial_id, "code": record.code, "text": record.text}
            found.append({"t": record.t_ns / 1e9, "part": part, "kept": kept, **row})
            if record.code == "resumed":
                # What ran when the session broke off is not part of it any more.
                running, anew = -1, found[-1]
    return [{**trial_keys(session, int(str(row["trial_id"]))), **row} for row in found]
