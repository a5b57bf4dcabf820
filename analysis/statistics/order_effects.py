"""Orders used, and means by condition, order and period: described; `crossover` tests."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pandas as pd


@dataclasses.dataclass(frozen=True, slots=True)
class OrderRow:
    """One condition within one order.

    Attributes:
        order: conditions in the order run.
        participants: who had that order and have data here, sorted.
        condition: the condition described.
        period: its place in the order, from 1.
        mean: mean of the participants' means, points a trial.
        standard_deviation: between those participants; None for one participant.
    """

    order: tuple[str, ...]
    participants: tuple[str, ...]
    condition: str
    period: int
    mean: float
    standard_deviation: float | None


def describe_orders(frame: pd.DataFrame, orders: dict[str, tuple[str, ...]]) -> list[OrderRow]:
    """Describe every order that was used.

    Args:
        frame: trial rows with "participant", "condition" and "team_reward".
        orders: each participant's conditions in the order run.
    """
    rows: list[OrderRow] = []
    present = set(frame["participant"])
    used = sorted({order for who, order in orders.items() if who in present})
    for order in used:
        people = tuple(sorted(w for w, o in orders.items() if o == order and w in present))
        for period, condition in enumerate(order, start=1):
            means = _participant_means(frame, people, condition)
            if means:
                values = list(means.values())
                spread = float(np.std(values, ddof=1)) if len(values) > 1 else None
                mean = float(np.mean(values))
                rows.append(OrderRow(order, tuple(means), condition, period, mean, spread))
    return rows


def period_means(rows: Sequence[OrderRow]) -> dict[int, float]:
    """Return the mean of each period, every participant counting once."""
    totals: dict[int, tuple[float, int]] = {}
    for row in rows:
        total, count = totals.get(row.period, (0.0, 0))
        n = len(row.participants)
        totals[row.period] = (total + n * row.mean, count + n)
    return {period: total / count for period, (total, count) in sorted(totals.items())}


def _participant_means(
    frame: pd.DataFrame, people: tuple[str, ...], condition: str
) -> dict[str, float]:
    chosen = frame[frame["condition"] == condition]
    means: dict[str, float] = {}
    for participant in people:
        rewards = chosen.loc[chosen["participant"] == participant, "team_reward"]
        if len(rewards):
            means[participant] = float(np.mean(np.sort(rewards.to_numpy(dtype=np.float64))))
    return means
