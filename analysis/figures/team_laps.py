"""Laps of the whole team in each trial, a column for each condition."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.figures.paired_means import swarm
from analysis.figures.svg import Drawing, Scale, tone, vertical_axis
from analysis.formatting import number
from analysis.laps import LapRow

WIDTH, HEIGHT = 920.0, 330.0
LEFT, TOP, BOTTOM = 42.0, 34.0, 270.0
COLUMN = 250.0
"""Width of a condition's column, px; less where there are many."""
GAP = 9.0


def team_laps(name: str, rows: Sequence[LapRow]) -> Drawing:
    """Draw each trial's laps as a dot, each participant's mean as a line, and the mean of all.

    Args:
        name: unique in the page.
        rows: a condition each, the reference first.
    """
    column = min(COLUMN, (WIDTH - LEFT) / max(len(rows), 1))
    right = LEFT + column * len(rows)
    spoken = "; ".join(
        f"{r.label} {number(r.per_trial, 1)}" for r in rows if r.per_trial is not None
    )
    drawing = Drawing(name, WIDTH, HEIGHT, f"Team laps per trial by condition: mean {spoken}")
    drawing.text((0, 14), "Team laps per trial", "f-ink bold", size=12)
    drawing.text((132, 14), "laps of all robots; a dot is a trial", "f-quiet", size=11.5)
    values = [laps for row in rows for own in row.laps.values() for laps in own]
    scale = Scale([0.0, *map(float, values)], BOTTOM, TOP, ticks=5)
    vertical_axis(drawing, scale, LEFT, right)
    for place, row in enumerate(rows):
        _column(drawing, row, place, LEFT + column * place, column, scale)
    return drawing


def _column(
    drawing: Drawing, row: LapRow, place: int, left: float, width: float, scale: Scale
) -> None:
    middle = left + width / 2
    dots = [laps for own in row.laps.values() for laps in own]
    heights = [scale(float(laps)) for laps in dots]
    shifts = swarm(heights, GAP)
    # Many trials of the same number of laps make a row wider than its column.
    reach = max((abs(shift) for shift in shifts), default=0.0)
    squeeze = min(1.0, (width / 2 - 50) / reach) if reach else 1.0
    for y, shift in zip(heights, shifts, strict=True):
        drawing.circle((middle + squeeze * shift, y), 3.6, f"f-{tone(place)} s-paper")
    if row.per_trial is not None:
        y = scale(row.per_trial)
        drawing.line((middle - width / 3, y), (middle + width / 3, y), f"s-{tone(place)} thick")
        at = (middle + width / 3 + 4, y + 4)
        drawing.text(at, number(row.per_trial, 1), f"t-{tone(place)} bold halo", size=12.5)
    drawing.text((middle, BOTTOM + 24), row.label, f"t-{tone(place)} bold", "middle", 12.5)
    trials = "trial" if row.trials == 1 else "trials"
    under = f"{row.total} laps in {row.trials} {trials}"
    drawing.text((middle, BOTTOM + 41), under, "f-quiet", "middle", 11.5)
