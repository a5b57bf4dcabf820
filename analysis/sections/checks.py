"""Assumption checks of the primary test."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import stats

from analysis.figures.checks import check_panels, left_out, trial_residuals
from analysis.figures.svg import Drawing
from analysis.formatting import number
from analysis.results import StudyResults
from analysis.statistics.result import EffectResult

ALPHA = 0.05


@dataclasses.dataclass(frozen=True, slots=True)
class CheckRow:
    """One check of the table.

    Attributes:
        name: what is checked.
        statistic: name and value as written, or empty.
        p: probability if the assumption held; None where there is none.
        reading: what follows, a sentence.
    """

    name: str
    statistic: str
    p: float | None
    reading: str


def _two(results: StudyResults) -> bool:
    return isinstance(results.primary, EffectResult) and len(results.cells.levels) == 2


def figure(results: StudyResults) -> Drawing | None:
    """Draw the checks; None unless two conditions were compared."""
    if not _two(results):
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
        fitted,
        residuals,
        places,
        results.labels,
    )


def rows(results: StudyResults) -> list[CheckRow]:
    """Compute the checks; empty unless two conditions were compared."""
    if not _two(results):
        return []
    cells = results.cells
    differences = cells.means[:, 1] - cells.means[:, 0]
    shapiro = stats.shapiro(np.sort(differences))
    made = [
        CheckRow(
            "Normal differences, Shapiro–Wilk",
            f"W = {number(float(shapiro.statistic))}",
            float(shapiro.pvalue),
            _normal(float(shapiro.pvalue), cells.n),
        )
    ]
    rest = left_out(differences)
    low, high = min(rest), max(rest)
    signs = {bounds[1] > 0 or bounds[2] < 0 for bounds in rest}
    reading = (
        "Whether zero lies in the interval does not hang on one participant"
        if len(signs) == 1
        else "Whether zero lies in the interval hangs on single participants"
    )
    who = (cells.participants[rest.index(low)], cells.participants[rest.index(high)])
    made.append(
        CheckRow(
            "Leave one participant out",
            f"{number(low[0])} (without {who[0]}) to {number(high[0])} (without {who[1]})",
            None,
            reading,
        )
    )
    if isinstance(results.primary, EffectResult):
        made += [
            CheckRow(
                check.name,
                f"{check.statistic_name} = {number(check.statistic)}",
                check.p,
                check.note,
            )
            for check in results.primary.checks
        ]
    return made


def finding(results: StudyResults) -> str:
    """Open the caption with what the checks show."""
    found = rows(results)
    against = [row.name.split(",")[0] for row in found if row.p is not None and row.p < ALPHA]
    if not against:
        return "No check argues against the primary test."
    return f"Look twice: {against[0].lower()}."


def _normal(p: float, n: int) -> str:
    if p < ALPHA:
        return "The differences do not look normal; see the rank and permutation tests"
    return f"Not contradicted; with {n} values the test has little power"
