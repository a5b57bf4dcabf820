"""One row a timestep of the fleet."""

from __future__ import annotations

import numpy as np

from analysis.recordings import Session, StudyRecordings
from analysis.tables.blocks import Block, Columns, build_from_blocks, key_columns, names_of
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS
from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("timestep", "integer", "number within the fleet run, from 0"),
    Column("t", "number", "time since the session opened", unit="s"),
    Column("late", "number", "how long after it was due", unit="s"),
    Column("operated", "integer", "number of the operated robot, from 1; 0 if none"),
    Column("choice_source", "label", "who decided which robot is operated"),
    Column("choice_flag", "label", "usable, or why a choice may not be fitted"),
    Column("action", "label", "executed action of the operated robot; empty if none"),
    Column("action_source", "label", "who decided that action; empty if none"),
    Column("active", "integer", "robots that were stepped"),
    Column("team_reward", "number", "sum of the robots' rewards of the step", unit="points"),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    return build_from_blocks(study, "timesteps", "One row a timestep.", COLUMNS, _columns)


def _columns(session: Session, block: Block) -> Columns:
    operated = block["operated"].astype(np.int64)
    rows = np.arange(operated.size)
    index = np.maximum(operated, 0)
    none = operated < 0
    # A code past the last name stands for "nobody operates".
    action_names = (*session.task.action_names, "")
    source_names = (*(source.name.lower() for source in ActionSource), "")
    action = np.where(none, len(action_names) - 1, block["actions"][rows, index])
    source = np.where(none, len(source_names) - 1, block["action_sources"][rows, index])
    t, due = block["t_ns"].astype(np.int64), block["due_ns"].astype(np.int64)
    return {
        **key_columns(session, block["trial_id"]),
        "timestep": block["timestep"].astype(np.int64),
        "t": t / 1e9,
        "late": (t - due) / 1e9,
        "operated": operated + 1,
        "choice_source": names_of(block["choice_source"], ChoiceSource),
        "choice_flag": names_of(block["choice_flag"], ChoiceFlag),
        "action": names_of(action, action_names),
        "action_source": names_of(source, source_names),
        "active": (block["action_sources"] != ActionSource.INACTIVE).sum(axis=1),
        "team_reward": block["rewards"].astype(np.float64).sum(axis=1),
    }
