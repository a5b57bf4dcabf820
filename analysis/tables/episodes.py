"""One row an episode: a robot from reset to end."""

from __future__ import annotations

from analysis.recordings import StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys
from study.events.codes import Outcome
from study.events.events import EpisodeEnded

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("robot", "integer", "number of the robot, from 1"),
    Column("episode", "integer", "number of the robot's episode within the fleet run, from 1"),
    Column("last_timestep", "integer", "the last timestep of the episode", unit="timesteps"),
    Column("length", "integer", "number of timesteps", unit="timesteps"),
    Column("outcome", "label", "goal, lost or time_up"),
    Column("episode_reward", "number", "sum of the episode's rewards", unit="points"),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [
        {
            **trial_keys(session, event.trial_id),
            "robot": event.robot + 1,
            "episode": event.episode,
            "last_timestep": event.timestep,
            "length": event.length,
            "outcome": Outcome(event.outcome).name.lower(),
            "episode_reward": event.episode_reward,
        }
        for session in study.sessions
        for _, event in session.recording.records(EpisodeEnded.topic)
        if isinstance(event, EpisodeEnded)
    ]
    return Table.from_rows("episodes", "One row an episode.", COLUMNS, rows)
