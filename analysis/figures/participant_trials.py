"""One participant's team reward, trial by trial, in the order run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.figures.svg import Drawing, Scale, tone, vertical_axis
from analysis.formatting import number

WIDTH, HEIGHT = 920.0, 176.0
LEFT, TOP, BOTTOM = 34.0, 14.0, 126.0


def participant_trials(
    name: str,
    participant: str,
    trials: pd.DataFrame,
    order: Sequence[str],
    levels: Sequence[str],
    labels: Sequence[str],
) -> Drawing:
    """Draw every trial, a block beside the other; broken-off trials are hollow.

    Args:
        name: unique in the page.
        participant: whose they are.
        trials: "condition", "trial", "team_reward" and "complete".
        order: conditions in the order run.
        levels: conditions, the reference first: they fix the colours.
        labels: the conditions' labels.
    """
    title = f"Team reward of {participant} by trial, in the order run"
    drawing = Drawing(name, WIDTH, HEIGHT, title)
    scale = Scale(list(trials["team_reward"]), BOTTOM, TOP, ticks=4)
    vertical_axis(drawing, scale, LEFT, WIDTH)
    run = [level for level in order if level in levels]
    run += [level for level in levels if level not in run]
    run = [level for level in run if (trials["condition"] == level).any()]
    longest = [int(trials.loc[trials["condition"] == level, "trial"].max()) for level in run]
    step = (WIDTH - LEFT) / max(sum(longest) + len(run) - 1, 1)
    start = LEFT + step / 2
    for level, count in zip(run, longest, strict=True):
        place = levels.index(level)
        own = trials[trials["condition"] == level].sort_values("trial")
        points = [
            (start + (int(t) - 1) * step, scale(float(r)))
            for t, r in zip(own["trial"], own["team_reward"], strict=True)
        ]
        drawing.polyline(points, f"s-{tone(place)} medium")
        for point, complete in zip(points, own["complete"], strict=True):
            fill = f"f-{tone(place)} s-paper" if complete else f"f-paper s-{tone(place)}"
            drawing.circle(point, 3.4, fill)
        middle = start + (count - 1) * step / 2
        whole = own.loc[own["complete"], "team_reward"]
        drawing.text((middle, BOTTOM + 22), labels[place], f"t-{tone(place)} bold", "middle", 12.5)
        if len(whole):
            written = f"mean {number(float(np.mean(whole)), 1)}"
            drawing.text((middle, BOTTOM + 38), written, "f-quiet", "middle", 11.5)
        start += count * step + step
        if level != run[-1]:
            edge = start - step
            drawing.line((edge, TOP - 6), (edge, BOTTOM), "s-quiet dotted")
    return drawing
