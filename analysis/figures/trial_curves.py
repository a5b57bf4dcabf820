"""Team reward over the trials of a session, one panel for each order of conditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from analysis.figures.paired_means import mean_interval
from analysis.figures.svg import Drawing, Scale, tone, vertical_axis
from analysis.formatting import number

WIDTH, PANEL_HEIGHT = 920.0, 286.0
LEFT, TOP, BOTTOM = 44.0, 34.0, 218.0


def trial_curves(
    name: str,
    trials: pd.DataFrame,
    orders: Mapping[str, tuple[str, ...]],
    levels: Sequence[str],
    labels: Sequence[str],
) -> Drawing:
    """Draw each participant's trials (thin) and their mean with a 95 % band.

    Args:
        name: unique in the page.
        trials: "participant", "condition", "trial" and "team_reward".
        orders: each participant's conditions in the order run.
        levels: conditions, the reference first: they fix the colours.
        labels: the conditions' labels.
    """
    present = set(trials["participant"])
    used = sorted({order for who, order in orders.items() if who in present})
    names = list(zip(levels, labels, strict=True))
    # Names of three or more conditions do not fit into half the width.
    across = 1 if len(used) == 1 or len(levels) > 2 else 2
    rows = (len(used) + across - 1) // across
    title = "Team reward by trial, a panel for each order of conditions"
    drawing = Drawing(name, WIDTH, rows * PANEL_HEIGHT, title)
    lasts = trials.groupby("condition", observed=True)["trial"].max()
    longest = {str(level): int(last) for level, last in lasts.items()}
    span = WIDTH if across == 1 else WIDTH / 2 - 20
    for place, order in enumerate(used):
        people = sorted(who for who, o in orders.items() if o == order and who in present)
        rows_here = trials[trials["participant"].isin(people)]
        column, row = place % across, place // across
        drawing.open_group(move=(column * (WIDTH / 2 + 20), row * PANEL_HEIGHT))
        first = labels[levels.index(order[0])] if order[0] in levels else order[0]
        drawing.text((0, 14), "abcdefghijkl"[place % 12], "f-ink bold", size=13)
        drawing.text((18, 14), f"{first} first", "f-ink bold", size=12)
        count = f"n = {len(people)}; team reward, points"
        drawing.text((30 + 7.0 * (len(first) + 6), 14), count, "f-quiet", size=11.5)
        scale = Scale(list(trials["team_reward"]), BOTTOM, TOP, ticks=5)
        vertical_axis(drawing, scale, LEFT, span)
        # Bands of few participants can reach far beyond every trial.
        clip = drawing.clip(f"panel{place}", [(LEFT, TOP - 8, span - LEFT, BOTTOM - TOP + 8)])
        _panel(
            drawing,
            rows_here,
            order,
            names=names,
            longest=longest,
            scale=scale,
            span=span,
            clip=clip,
        )
        drawing.close_group()
    return drawing


def _panel(
    drawing: Drawing,
    trials: pd.DataFrame,
    order: Sequence[str],
    *,
    names: Sequence[tuple[str, str]],
    longest: Mapping[str, int],
    scale: Scale,
    span: float,
    clip: str,
) -> None:
    levels = [name for name, _ in names]
    total = sum(longest.get(level, 1) for level in order)
    step = (span - LEFT) / max(total, 1)
    done = 0
    for condition in order:
        if condition not in levels:
            continue
        place = levels.index(condition)
        label = names[place][1]
        chosen = trials[trials["condition"] == condition]
        count = longest.get(condition, 1)
        x0 = LEFT + (done + 0.5) * step

        def x(trial: float, start: float = x0) -> float:
            return start + (trial - 1) * step

        for _, own in chosen.groupby("participant", observed=True):
            pairs = sorted(zip(own["trial"], own["team_reward"], strict=True))
            drawing.polyline([(x(t), scale(r)) for t, r in pairs], f"s-{tone(place)} faint")
            if len(pairs) == 1:
                trial, reward = pairs[0]
                drawing.circle((x(trial), scale(reward)), 2.4, f"none s-{tone(place)} faint")
        means: list[tuple[float, float]] = []
        band: list[tuple[float, float, float]] = []
        for trial in range(1, count + 1):
            rewards = np.sort(chosen.loc[chosen["trial"] == trial, "team_reward"].to_numpy())
            if rewards.size:
                interval = mean_interval(rewards)
                means.append((x(trial), scale(float(rewards.mean()))))
                band.append((x(trial), scale(interval.low), scale(interval.high)))
        upper = [(px, high) for px, _, high in band]
        lower = [(px, low) for px, low, _ in reversed(band)]
        drawing.open_group(clip=clip)
        drawing.polygon([*upper, *lower], f"f-{tone(place)} band")
        drawing.close_group()
        drawing.polyline(means, f"s-{tone(place)} medium")
        for point in means:
            drawing.circle(point, 3, f"f-{tone(place)} s-paper")
        for trial in sorted({1, (count + 1) // 2, count}):
            drawing.text((x(trial), BOTTOM + 18), str(done + trial), "f-quiet", "middle", 11.5)
        middle = (x(1) + x(count)) / 2
        drawing.text((middle, BOTTOM + 37), label, f"t-{tone(place)} bold", "middle", 12.5)
        if len(chosen):
            # Every participant counts once, however many trials there are.
            own_means = chosen.groupby("participant", observed=True)["team_reward"].mean()
            mean = float(np.mean(np.sort(own_means.to_numpy())))
            text = f"mean {number(mean, 1)}"
            drawing.text((middle, BOTTOM + 53), text, "f-quiet", "middle", 11.5)
        done += count
        if done < total:
            edge = x(count) + step / 2
            drawing.line((edge, TOP - 8), (edge, BOTTOM), "s-quiet dotted")
