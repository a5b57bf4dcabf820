"""One row for each robot and timestep: the long form."""

from __future__ import annotations

import numpy as np

from analysis.recordings import Session, StudyRecordings
from analysis.tables.blocks import Block, Columns, build_from_blocks, key_columns, names_of
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS
from study.events.codes import ActionSource, Outcome
from study.events.task_description import TaskDescription


def columns(task: TaskDescription) -> tuple[Column, ...]:
    """Return the columns: one for each number of the task's state among them."""
    states = [
        Column(f"state_{field.name}", "number", "before the step", field.unit)
        for field in task.state_fields
    ]
    return (
        *SESSION_COLUMNS,
        *TRIAL_COLUMNS,
        Column("timestep", "integer", "number within the fleet run, from 0"),
        Column("robot", "integer", "number of the robot, from 1"),
        *states,
        Column("action", "label", "executed action"),
        Column("action_source", "label", "who decided it"),
        Column("reward", "number", "reward of the step", unit="points"),
        Column("outcome", "label", "how the robot stands after the step"),
        Column("available", "boolean", "whether it could be chosen"),
        Column("operated", "boolean", "whether it was"),
        Column("score", "number", "scorer's value of the state; missing if none"),
    )


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    text = "One row for each robot and timestep."
    return build_from_blocks(study, "robots", text, columns(study.first.task), _columns)


def _columns(session: Session, block: Block) -> Columns:
    rows, n = block["rewards"].shape
    robot = np.tile(np.arange(n, dtype=np.int64), rows)
    states = block["states"].reshape(rows * n, -1).astype(np.float64)
    scores = block["scores"]
    scored = scores.ndim == 2 and scores.shape[1] > 0
    return {
        **key_columns(session, np.repeat(block["trial_id"], n)),
        "timestep": np.repeat(block["timestep"].astype(np.int64), n),
        "robot": robot + 1,
        **{
            f"state_{field.name}": states[:, place]
            for place, field in enumerate(session.task.state_fields)
        },
        "action": names_of(block["actions"].ravel(), session.task.action_names),
        "action_source": names_of(block["action_sources"].ravel(), ActionSource),
        "reward": block["rewards"].ravel().astype(np.float64),
        "outcome": names_of(block["outcomes"].ravel(), Outcome),
        "available": block["available"].ravel().astype(bool),
        "operated": np.repeat(block["operated"].astype(np.int64), n) == robot,
        "score": scores.ravel().astype(np.float64) if scored else np.full(rows * n, np.nan),
    }
