"""One row an intervention: consecutive operator-driven timesteps on one robot."""

from __future__ import annotations

import numpy as np

from analysis.recordings import Session, StudyRecordings
from analysis.tables.blocks import Block, Columns, build_from_blocks, key_columns
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS
from study.events.codes import ActionSource

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("robot", "integer", "number of the robot, from 1"),
    Column("first_timestep", "integer", "where it begins"),
    Column("length", "integer", "operator-driven timesteps in a row", unit="timesteps"),
    Column("robot_reward", "number", "sum of that robot's rewards meanwhile", unit="points"),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    text = "One row an intervention: consecutive operator-driven timesteps on one robot."
    return build_from_blocks(study, "interventions", text, COLUMNS, _columns)


def _columns(session: Session, block: Block) -> Columns:
    operated = block["operated"].astype(np.int64)
    rows = np.arange(operated.size)
    robot = np.maximum(operated, 0)
    driven = (operated >= 0) & (block["action_sources"][rows, robot] == ActionSource.OPERATOR)
    trial, timestep = block["trial_id"].astype(np.int64), block["timestep"].astype(np.int64)
    follows = np.zeros(rows.size, dtype=bool)
    follows[1:] = (
        driven[1:]
        & driven[:-1]
        & (robot[1:] == robot[:-1])
        & (trial[1:] == trial[:-1])
        & (timestep[1:] == timestep[:-1] + 1)
    )
    starts = np.flatnonzero(driven & ~follows)
    groups = np.cumsum(driven & ~follows)[driven] - 1
    reward = block["rewards"][rows, robot].astype(np.float64)[driven]
    return {
        **key_columns(session, trial[starts]),
        "robot": robot[starts] + 1,
        "first_timestep": timestep[starts],
        "length": np.bincount(groups, minlength=starts.size).astype(np.int64),
        "robot_reward": np.bincount(groups, weights=reward, minlength=starts.size),
    }
