"""Laps of the team: the figure and its table; nothing where the task has no laps."""

from __future__ import annotations

from analysis.figures.svg import Drawing
from analysis.figures.team_laps import team_laps
from analysis.formatting import listed, number
from analysis.laps import LapRow, lap_rows
from analysis.results import StudyResults


def rows(results: StudyResults) -> list[LapRow]:
    """Return a row for each condition; empty where there are no laps or no trials."""
    found = lap_rows(results)
    return found if any(row.trials for row in found) else []


def figure(found: list[LapRow]) -> Drawing | None:
    """Draw the laps of each trial; None without any."""
    return team_laps("laps", found) if found else None


def finding(found: list[LapRow]) -> str:
    """Say the means, in one sentence."""
    known = [(row.label, row.per_trial) for row in found if row.per_trial is not None]
    if not known:
        return ""
    (first, mean), *others = known
    means = [f"{number(mean, 1)} laps under {first}"]
    means += [f"{number(mean, 1)} under {label}" for label, mean in others]
    return f"On average the team drove {listed(means)} in a trial."
