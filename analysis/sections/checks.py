"""Assumption checks of the primary test."""

from __future__ import annotations

import numpy as np

from analysis.figures.checks import check_panels, trial_residuals
from analysis.figures.svg import Drawing
from analysis.formatting import listed
from analysis.results import StudyResults
from analysis.statistics.leave_one_out import LeaveOneOut
from analysis.statistics.result import ALPHA, Check, EffectResult, Interval


def figure(results: StudyResults) -> Drawing | None:
    """Draw the checks; None unless two conditions were compared."""
    if results.robustness is None:
        return None
    cells, trials = results.cells, results.data.trials
    used = trials[trials["participant"].isin(cells.participants)]
    used = used[used["condition"].isin(list(cells.levels))]
    used = used.sort_values(["participant", "condition", "trial"], kind="stable")
    rows = [
        (str(who), str(condition), float(reward))
        for who, condition, reward in zip(
            used["participant"], used["condition"], used["team_reward"], strict=True
        )
    ]
    fitted, residuals = trial_residuals(rows)
    places = np.array([cells.levels.index(condition) for _, condition, _ in rows], dtype=np.int64)
    return check_panels(
        "checks",
        cells.means[:, 1] - cells.means[:, 0],
        cells.participants,
        _without(results),
        fitted,
        residuals,
        places,
        results.labels,
    )


def rows(results: StudyResults) -> list[Check]:
    """Return the checks that were computed: normal differences, sphericity."""
    found: list[Check] = []
    if results.robustness is not None and isinstance(results.robustness.normality, Check):
        found.append(results.robustness.normality)
    if isinstance(results.primary, EffectResult):
        found += results.primary.checks
    return found


def finding(results: StudyResults) -> str:
    """Open the caption with what the checks show."""
    against = [check.name for check in rows(results) if check.p is not None and check.p < ALPHA]
    if not against:
        return "No check argues against the primary test."
    return f"Look twice: {listed(against)}, p below .05."


def _without(results: StudyResults) -> list[tuple[float, Interval]]:
    """Return estimate and interval without each participant; empty if too few would be left."""
    left = results.robustness.left_out if results.robustness is not None else None
    if not isinstance(left, LeaveOneOut):
        return []
    return [
        (each.result.estimate, each.result.interval)
        for each in left.each
        if each.result.estimate is not None and each.result.interval is not None
    ]
