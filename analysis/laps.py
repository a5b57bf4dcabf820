"""Laps, from recordings alone: what the map says of gates, and what the points say of laps."""

from __future__ import annotations

import dataclasses

import pandas as pd

from analysis.results import StudyResults
from study.events.task_description import TaskDescription

LAP = "lap"
"""Name of the points' term that a lap earns."""


@dataclasses.dataclass(frozen=True, slots=True)
class LapRow:
    """A condition's laps.

    Attributes:
        label: of the condition.
        trials: how many were run to their end and analysed.
        total: laps of all robots in them.
        per_trial: mean, all robots of a trial together; None without a trial.
        means: mean of each participant's trials, by participant.
        laps: of each trial, by participant, in the order run.
    """

    label: str
    trials: int
    total: int
    per_trial: float | None
    means: dict[str, float]
    laps: dict[str, tuple[int, ...]]


def points_of_a_lap(task: TaskDescription) -> float | None:
    """Return the points that a lap earns; None where laps cannot be told from points.

    They can where the map has gates, and a lap is all that earns anything.
    """
    earning = {term.name: term.value for term in task.rewards if term.value}
    return earning[LAP] if task.scene.gates and list(earning) == [LAP] else None


def lap_rows(results: StudyResults) -> list[LapRow]:
    """Count the laps of each condition; empty where the task has none, or tasks differ."""
    worth = {points_of_a_lap(session.task) for session in results.study.sessions}
    points = worth.pop() if len(worth) == 1 else None
    if points is None:
        return []
    trials = results.data.trials
    rows = []
    for condition in results.facts.conditions:
        own = trials[trials["condition"] == condition.name]
        laps = (own["team_reward"] / points).round().astype(int)
        by_person = {str(who): part for who, part in laps.groupby(own["participant"])}
        rows.append(
            LapRow(
                label=condition.label,
                trials=len(own),
                total=int(laps.sum()),
                per_trial=float(laps.mean()) if len(own) else None,
                means={who: float(part.mean()) for who, part in by_person.items()},
                laps={who: _in_order(own, part) for who, part in by_person.items()},
            )
        )
    return rows


def _in_order(trials: pd.DataFrame, laps: pd.Series[int]) -> tuple[int, ...]:
    order = trials.loc[laps.index, "trial"].sort_values().index
    return tuple(int(each) for each in laps.loc[order])
