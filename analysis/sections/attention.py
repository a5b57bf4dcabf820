"""Attention: measures of supervisory control under each condition, and their tests."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd

from analysis.attention import SETTLING
from analysis.figures.measure_panels import measure_panels
from analysis.figures.svg import Drawing
from analysis.formatting import counted, listed, number
from analysis.results import StudyResults
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.holm import holm_of
from analysis.statistics.pairs import differences
from analysis.statistics.result import ALPHA, EffectResult, Outcome, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.wilcoxon import signed_rank
from analysis.tables.attention import MEASURES

NAMES = {
    "attended": "Time attended",
    "takeovers": "Takeovers",
    "dwell": "Dwell",
    "switch_lag": "Switch lag",
    "switch_cost": "Switch cost",
    "neglect_time": "Neglect time",
    "stuck_spells": "Stuck spells",
    "stuck_helped": "Stuck and helped",
    "stuck_wait": "Wait of a stuck robot",
    "stuck_share": "Neglected time stuck",
    "neglect_tolerance": "Neglect tolerance",
    "fan_out": "Fan-out",
    "fan_out_with_wait": "Fan-out with wait",
    "actions": "Actions",
    "reward_per_action": "Return on actions",
    "presses": "Presses",
    "reward_per_press": "Return on presses",
}
DRAWN = (
    *("dwell", "switch_lag", "switch_cost", "neglect_time"),
    *("stuck_wait", "fan_out", "reward_per_action", "reward_per_press"),
)
UNITS = {
    "attended": "share of timesteps",
    "stuck_helped": "share of spells",
    "takeovers": "a trial",
}
UNITS |= {"stuck_share": "share of that time", "stuck_spells": "a trial"}


@dataclasses.dataclass(frozen=True, slots=True)
class MeasureRow:
    """One measure under every condition.

    Attributes:
        key: its column.
        name, unit: as written.
        cells: participants' means.
        test: paired, or a repeated-measures ANOVA.
        holm_p: over the measures that were tested.
        rank_test: exact Wilcoxon; None unless there are two conditions.
        trials: how many trials gave the measure, and of how many.
    """

    key: str
    name: str
    unit: str
    cells: Cells
    test: Outcome
    holm_p: float | None
    rank_test: Outcome | None
    trials: tuple[int, int]

    @property
    def decimals(self) -> int:
        """With how many decimals its means are written."""
        size = float(np.abs(self.cells.means).max()) if self.cells.n else 0.0
        return 1 if size >= 20 else 2


def rows(results: StudyResults) -> list[MeasureRow]:
    """Compare conditions on every measure that anybody's trials gave."""
    frame = _frame(results)
    levels = results.facts.levels
    found: list[MeasureRow] = []
    for column in MEASURES:
        given = frame[np.isfinite(frame[column.name].to_numpy())]
        if not len(given):
            continue
        cells = cell_means(given, column.name, levels, what="trials that give it")
        test = rm_anova(cells, NAMES[column.name], "sensitivity", len(given))
        gaps = differences(cells, NAMES[column.name]) if len(levels) == 2 else None
        ranks = signed_rank(gaps, cells.participants) if isinstance(gaps, np.ndarray) else gaps
        found.append(
            MeasureRow(
                key=column.name,
                name=NAMES[column.name],
                unit=UNITS.get(column.name, column.unit),
                cells=cells,
                test=test,
                holm_p=None,
                rank_test=ranks,
                trials=(len(given), len(frame)),
            )
        )
    adjusted = holm_of([row.test for row in found])
    return [dataclasses.replace(r, holm_p=p) for r, p in zip(found, adjusted, strict=True)]


def figure(results: StudyResults, measured: list[MeasureRow]) -> Drawing | None:
    """Draw the main measures; None if nobody has one under every condition."""
    known = {row.key: row for row in measured if row.cells.n}
    panels = [(known[k].name, known[k].unit, known[k].cells) for k in DRAWN if k in known]
    if not panels:
        return None
    title = f"{counted(len(panels), 'measure')} of attention, participants' means by condition"
    return measure_panels("attention", panels, results.labels, title)


def finding(results: StudyResults, measured: list[MeasureRow]) -> str:
    """Say on which measures the conditions differed after Holm's adjustment."""
    tested = [row for row in measured if isinstance(row.test, EffectResult)]
    if not tested:
        return "No measure could be compared between conditions."
    differ = [row for row in tested if (row.holm_p or 0.0) < ALPHA]
    if not differ:
        return (
            f"No difference between conditions was detected on any of "
            f"{counted(len(tested), 'measure')}."
        )
    return (
        f"After Holm’s adjustment over {counted(len(tested), 'measure')}, conditions differed on "
        f"{listed([_way(results, row) for row in differ])}."
    )


def absent(results: StudyResults, measured: list[MeasureRow]) -> list[Refusal]:
    """Say which measures these recordings do not give, and why."""
    frame = _frame(results)
    if not len(frame):
        reason = "These recordings hold no complete trial of phase three with an operator."
        return [Refusal("Attention", reason)]
    known = {row.key for row in measured}
    why: dict[str, list[str]] = {}
    for column in MEASURES:
        if column.name not in known:
            why.setdefault(_reason(results, column.name), []).append(NAMES[column.name])
    found = [Refusal(listed(names), reason) for reason, names in why.items()]
    refused: dict[str, list[str]] = {}
    for row in measured:
        if isinstance(row.test, Refusal):
            refused.setdefault(row.test.reason, []).append(row.name.lower())
    return found + [
        Refusal(f"Comparison of {listed(names)}", reason) for reason, names in refused.items()
    ]


def _frame(results: StudyResults) -> pd.DataFrame:
    """Return the attention of the trials that the tests of team reward rest on."""
    frame = results.tables.frame("attention")
    used = results.data.trials
    wanted = set(zip(used["session"].astype(str), used["trial_id"], strict=True))
    keys = zip(frame["session"].astype(str), frame["trial_id"], strict=True)
    return frame[np.array([key in wanted for key in keys], dtype=bool)]


def _reason(results: StudyResults, measure: str) -> str:
    task = results.study.first.task
    if measure == "switch_cost":
        return f"No robot was attended to for more than {SETTLING} timesteps at a time."
    if measure == "switch_lag":
        return "In no trial was more than one robot taken over."
    if measure in ("presses", "reward_per_press"):
        return "These recordings hold no keys or buttons."
    if measure.startswith(("stuck", "neglect_tolerance", "fan_out")):
        if min(task.x_field, task.y_field) < 0:
            return (
                f"Robots of the task {task.name} have no place, so that none is seen to be stuck."
            )
        timing = results.study.first.protocol.get("timing")
        if not isinstance(timing, dict) or "timesteps_per_second" not in timing:
            return "The recorded protocol does not say how long a timestep lasts."
        return "No robot was ever stuck, or lost, while nobody attended to it."
    return "No trial gives it."


def _way(results: StudyResults, row: MeasureRow) -> str:
    test = row.test
    if len(results.labels) != 2 or not isinstance(test, EffectResult) or test.estimate is None:
        return row.name.lower()
    more = "higher" if test.estimate > 0 else "lower"
    size = number(abs(test.estimate), row.decimals)
    return f"{row.name.lower()} ({size} {more} under {results.labels[1]})"
