"""One row a choice: the robot operated at a timestep, with its state before the step."""

from __future__ import annotations

import numpy as np

from analysis.recordings import Session, StudyRecordings
from analysis.tables.blocks import Block, Columns, build_from_blocks, key_columns, names_of
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS
from study.events.codes import ChoiceFlag, ChoiceSource
from study.events.task_description import TaskDescription


def columns(task: TaskDescription) -> tuple[Column, ...]:
    """Return the columns: one for each number of the task's state among them."""
    states = [
        Column(f"state_{field.name}", "number", "of the chosen robot, before the step", field.unit)
        for field in task.state_fields
    ]
    return (
        *SESSION_COLUMNS,
        *TRIAL_COLUMNS,
        Column("timestep", "integer", "number within the fleet run, from 0"),
        Column("chosen", "integer", "number of the robot operated, from 1"),
        Column("source", "label", "operator, scorer or accepted_suggestion"),
        Column("flag", "label", "usable, or why it may not be fitted"),
        Column("available", "integer", "robots that could be chosen"),
        *states,
        Column("score", "number", "scorer's value of the chosen robot; missing if none"),
        Column("score_rank", "number", "1 if no available robot scored higher; missing if none"),
    )


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings.

    The states of the robots that were not chosen are in the table of robots, by the same
    participant, fleet run and timestep.
    """
    declared = columns(study.first.task)
    text = "One row a choice: a timestep at which a robot was operated."
    return build_from_blocks(study, "choices", text, declared, _columns)


def _columns(session: Session, block: Block) -> Columns:
    rows = np.flatnonzero(block["operated"] >= 0)
    chosen = block["operated"][rows].astype(np.int64)
    available = block["available"][rows].astype(bool)
    scores = block["scores"][rows]
    if scores.ndim == 2 and scores.shape[1] > 0:
        score = scores[np.arange(rows.size), chosen].astype(np.float64)
        rank = 1.0 + (available & (scores > score[:, None])).sum(axis=1)
    else:
        score = rank = np.full(rows.size, np.nan)
    states = block["states"][rows, chosen].astype(np.float64)
    return {
        **key_columns(session, block["trial_id"][rows]),
        "timestep": block["timestep"][rows].astype(np.int64),
        "chosen": chosen + 1,
        "source": names_of(block["choice_source"][rows], ChoiceSource),
        "flag": names_of(block["choice_flag"][rows], ChoiceFlag),
        "available": available.sum(axis=1),
        **{
            f"state_{field.name}": states[:, place]
            for place, field in enumerate(session.task.state_fields)
        },
        "score": score,
        "score_rank": rank,
    }
