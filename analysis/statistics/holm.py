"""Holm's step-down adjustment of a family of p values."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.statistics.result import EffectResult, Outcome


def holm(p_values: Sequence[float]) -> list[float]:
    """Return the adjusted p values, in the order given.

    Source: Holm (1979), Scandinavian Journal of Statistics 6, 65-70.
    """
    order = sorted(range(len(p_values)), key=lambda place: p_values[place])
    adjusted = [0.0] * len(p_values)
    largest = 0.0
    for rank, place in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[place]))
        adjusted[place] = largest
    return adjusted


def holm_of(outcomes: Sequence[Outcome]) -> list[float | None]:
    """Adjust the tests that were computed over one another; None in the place of each refusal."""
    adjusted = iter(holm([o.p for o in outcomes if isinstance(o, EffectResult)]))
    return [next(adjusted) if isinstance(o, EffectResult) else None for o in outcomes]
