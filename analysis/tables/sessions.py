"""One row a session."""

from __future__ import annotations

from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table

COLUMNS = (
    *SESSION_COLUMNS,
    Column("file", "text", "name of the recording"),
    Column("file_sha256", "text", "SHA-256 of the recording, hexadecimal"),
    Column("operator_kind", "label", '"person" or "simulated"'),
    Column("operator_parameters", "text", "parameters of a simulated operator, JSON object"),
    Column("seed", "text", "session seed; text, since it may exceed 64 signed bits"),
    Column("order", "label", "conditions of phase three in the order run"),
    Column(
        "planned_index",
        "integer",
        "place in the plan when the session was opened, from 0; -1 unknown. It may be somebody "
        "else's by now: see slot",
    ),
    Column(
        "slot",
        "integer",
        "slot that the participant holds now, by the register, from 1; 0 for none, as with "
        "drop-outs; -1 if no register tells",
    ),
    Column("started_utc", "text", "wall time of opening, ISO 8601, UTC"),
    Column("minutes", "number", "from opening to the last event", unit="min"),
    Column("complete", "boolean", "whether every stage was passed and the file is whole"),
    Column("file_complete", "boolean", "whether the file was finished properly"),
    Column("ended", "text", "why the session ended; empty if its end is not recorded"),
    Column("fleet_runs", "integer", "fleet runs begun"),
    Column("left_out_trials", "integer", "fleet runs broken off by a crash and run again"),
    Column("problems", "text", "what is wrong with the file, in words"),
    Column("protocol_sha256", "text", "SHA-256 of the protocol, hexadecimal"),
    Column("versions", "text", "versions of what ran, JSON object"),
)


def order_text(order: tuple[str, ...]) -> str:
    """Return an order as one value: "manual, assisted"."""
    return ", ".join(order)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [_row(session) for session in study.sessions]
    return Table.from_rows("sessions", "One row a session.", COLUMNS, rows)


def _row(session: Session) -> dict[str, object]:
    opened, ended = session.opened, session.ended
    last = ended.t_ns if ended else max((e.t_ns for e in session.trial_ends.values()), default=0)
    return {
        "participant": opened.participant,
        "session": opened.session_id,
        "file": session.file,
        "file_sha256": session.recording.sha256,
        "operator_kind": opened.operator_kind,
        "operator_parameters": opened.operator_json,
        "seed": str(opened.seed),
        "order": order_text(opened.order),
        "planned_index": opened.planned_index,
        "slot": session.slot,
        "started_utc": opened.started_utc,
        "minutes": last / 60e9,
        "complete": session.complete,
        "file_complete": session.recording.complete,
        "ended": ended.reason if ended else "",
        "fleet_runs": len(session.trials),
        "left_out_trials": session.left_out_trials,
        "problems": "; ".join(session.recording.problems),
        "protocol_sha256": opened.protocol_sha256,
        "versions": opened.versions_json,
    }
