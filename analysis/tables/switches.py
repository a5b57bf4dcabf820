"""One row a switch: from then on another robot is operated."""

from __future__ import annotations

from analysis.recordings import StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys
from study.events.codes import ChoiceSource
from study.events.events import Switched

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("timestep", "integer", "the first timestep that it applies to"),
    Column("t", "number", "time since the session opened", unit="s"),
    Column("from_robot", "integer", "number of the robot left, from 1; 0 if none"),
    Column("to_robot", "integer", "number of the robot taken over, from 1; 0 if none"),
    Column("takeover", "boolean", "whether a robot was taken over"),
    Column("source", "label", "who decided"),
    Column("cause", "label", "number, tab, pointer, accept, dwell, ended or start"),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [
        {
            **trial_keys(session, event.trial_id),
            "timestep": event.timestep,
            "t": event.t_ns / 1e9,
            "from_robot": event.from_robot + 1,
            "to_robot": event.to_robot + 1,
            "takeover": event.to_robot >= 0,
            "source": ChoiceSource(event.source).name.lower(),
            "cause": event.cause,
        }
        for session in study.sessions
        for _, event in session.recording.records(Switched.topic)
        if isinstance(event, Switched)
    ]
    return Table.from_rows("switches", "One row a switch.", COLUMNS, rows)
