"""The figures of what-if, from its tables."""

from __future__ import annotations

import numpy as np
import pandas as pd

from analysis.figures.svg import Drawing
from analysis.figures.what_if import Dot, dot_panels, matrix_cells, parting_panels
from analysis.formatting import scorer_name
from analysis.sections.what_if import VALIDATED, Matrix, Mean, RegretRow, ScorerRow
from analysis.what_if import WhatIf, pooled

MOST_LINES = 6


def scorer_dots(rows: list[ScorerRow]) -> Drawing | None:
    """Draw agreement and likelihood of every scorer on choices after the fits, or else before."""
    shown = [row for row in rows if row.group == "later"] or rows
    if not shown:
        return None
    chance = float(np.mean([row.chance.value for row in shown]))
    panels = [
        ("Agreement", "share of choices", [_dot(row.agreement) for row in shown], chance),
        ("Log-likelihood above chance", "nats", [_dot(row.gain) for row in shown], None),
    ]
    title = f"Agreement and likelihood of {len(shown)} scorers, means over participants"
    return dot_panels(
        "whatif-scorers", [scorer_name(row.scorer) for row in shown], panels, title, "no likelihood"
    )


def regret_dots(rows: list[RegretRow]) -> Drawing | None:
    """Draw regret and the share of choices without any, of whoever chose."""
    if not rows:
        return None
    shares = [None if row.who == "chance" else _dot(row.best) for row in rows]
    panels = [
        ("Regret", "points a choice", [_dot(row.regret) for row in rows], None),
        ("Without regret", "share of choices", shares, None),
    ]
    title = f"Regret of {len(rows)} ways to choose, means over participants"
    return dot_panels("whatif-regret", [scorer_name(row.who) for row in rows], panels, title, "")


def matrix_figure(found: Matrix | None) -> Drawing | None:
    """Draw the matrix of agreement; None if there is none."""
    if found is None:
        return None
    title = f"Share of choices of {len(found.people)} participants that each one’s scorer names"
    return matrix_cells("whatif-matrix", found.owners, found.people, found.agreement, title)


def partings(what: WhatIf) -> Drawing | None:
    """Draw where scorers and operators part: along time, and along the chosen robot's state."""
    times, states = what.tables["times"], what.tables["states"]
    names = [name for name in dict.fromkeys(times["scorer"]) if name != VALIDATED][:MOST_LINES]
    times = times[times["scorer"].isin(names)]
    if not len(times):
        return None
    along = times.assign(at=(times["bin"] - 0.5) / 10)
    panels = [("Time in the trial", "share of its length", *_lines(along, names))]
    for field in dict.fromkeys(states["field"]):
        mine = states[(states["field"] == field) & states["scorer"].isin(names)]
        if len(mine):
            middle = mine.assign(at=(mine["low"] + mine["high"]) / 2)
            unit = str(mine["unit"].iloc[0])
            panels.append((f"Chosen robot’s {field}", unit, *_lines(middle, names)))
    title = f"Agreement of {len(names)} scorers along time and state"
    return parting_panels("whatif-partings", panels, title)


def _lines(
    frame: pd.DataFrame, names: list[str]
) -> tuple[list[tuple[str, list[tuple[float, float]]]], list[tuple[float, float]]]:
    """Return a line for each scorer and one for chance: means over participants in each bin."""
    people = pooled(frame, ["scorer", "at", "participant"], ["agreement", "chance_agreement"])
    lines = []
    for name in names:
        mine = people[people["scorer"] == name].groupby("at")["agreement"].mean()
        lines.append((scorer_name(name), [(float(at), float(value)) for at, value in mine.items()]))  # type: ignore[arg-type]
    chance = people.groupby("at")["chance_agreement"].mean()
    return lines, [(float(at), float(value)) for at, value in chance.items()]  # type: ignore[arg-type]


def _dot(mean: Mean) -> Dot | None:
    return (mean.value, mean.interval) if mean.n else None
