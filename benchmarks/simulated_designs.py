"""Studies whose truth is known: what `benchmarks.statistics_error_rates` tests over and over.

Two conditions of eight trials, AB/BA, as twelve participants run them; three conditions in
balanced Latin squares, whose effects scatter unequally from person to person; two crossed factors
of two and three levels. All on the scale of points a trial.
"""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.statistics.cells import Cells

Floats = npt.NDArray[np.float64]
PEOPLE, TRIALS = 12, 8
LEVEL_SD, EFFECT_SD, TRIAL_SD = 11.0, 5.0, 10.5
EFFECT = 6.0  # points a trial
PERIOD, CARRY = 5.0, 8.0  # points a trial; only in the studies that test for them
THREE = ("a", "b", "c")
UNEQUAL_SD = (0.0, 4.0, 10.0)  # of the effect of each condition between people: not spherical
FACTORS = {"allocation": ("manual", "assisted"), "fleet": ("4", "12", "48")}


def period_and_carry_over(frame: pd.DataFrame, reference: str, period: float, carry: float) -> None:
    """Add a period effect, and what an assisted first block leaves behind, in place."""
    second = frame["period"] == 2
    frame.loc[second, "team_reward"] += period
    # In the second period of those whose first condition was not the reference.
    left = second & (frame["condition"] == reference)
    frame.loc[left, "team_reward"] += carry


def three_conditions(
    effect: float,
    generator: np.random.Generator,
    spread: tuple[float, ...],
    period: float = 0.0,
    carry: float = 0.0,
) -> tuple[Cells, dict[str, tuple[str, ...]]]:
    """Return means under three conditions, and each participant's order: all six, twice.

    Args:
        effect: of the third condition; the second has half of it.
        generator: of the scatter.
        spread: standard deviation between people of each condition's effect.
        period: of the third period; the second has half of it.
        carry: what the third condition leaves behind; the second half of it.
    """
    truth = np.array([0.0, 0.5, 1.0])
    orders = list(itertools.permutations(range(3))) * (PEOPLE // 6)
    means = np.zeros((PEOPLE, 3))
    for person, order in enumerate(orders):
        own = generator.normal(50, LEVEL_SD) + effect * truth
        own = own + generator.normal(0, 1, 3) * np.array(spread)
        own = own + generator.normal(0, TRIAL_SD, (TRIALS, 3)).mean(axis=0)
        for place, condition in enumerate(order):
            own[condition] += period * place / 2
            if place:
                own[condition] += carry * truth[order[place - 1]]
        means[person] = own
    who = tuple(f"P{person:02d}" for person in range(PEOPLE))
    run = {p: tuple(THREE[c] for c in order) for p, order in zip(who, orders, strict=True)}
    return Cells(who, THREE, means, np.full((PEOPLE, 3), TRIALS)), run


def two_factors(effect: float, generator: np.random.Generator) -> pd.DataFrame:
    """Return a row for each participant and cell of two crossed factors.

    Each factor has this effect between its first and its last level, and so has the interaction;
    all vary truly between people.
    """
    a, b = FACTORS.values()
    rows = []
    for person in range(PEOPLE):
        level = generator.normal(50, LEVEL_SD)
        gain = generator.normal(effect, EFFECT_SD)
        size = generator.normal(0, EFFECT_SD, 3) + effect * np.array([0.0, 0.5, 1.0])
        both = generator.normal(0, EFFECT_SD, 3) + effect * np.array([0.0, 0.5, 1.0])
        for i, allocation in enumerate(a):
            for j, fleet in enumerate(b):
                noise = generator.normal(0, TRIAL_SD, TRIALS).mean()
                value = level + gain * i + size[j] + both[j] * (i - 0.5) + noise
                rows.append((f"P{person:02d}", allocation, fleet, value))
    return pd.DataFrame(rows, columns=["participant", *FACTORS, "reward"])
