"""What every statistical test returns: one typed result, or a refusal with its reason."""

from __future__ import annotations

import dataclasses
from typing import Literal

Role = Literal["primary", "sensitivity", "comparison"]


@dataclasses.dataclass(frozen=True, slots=True)
class Interval:
    """A confidence interval."""

    low: float
    high: float
    level: float = 0.95

    def holds(self, value: float) -> bool:
        """Return whether the value lies within the interval, ends included."""
        return self.low <= value <= self.high


@dataclasses.dataclass(frozen=True, slots=True)
class EffectSize:
    """A standardised effect: "d_z", "partial eta squared", ..."""

    name: str
    value: float
    interval: Interval | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class Excluded:
    """A participant who did not enter a test, and why in words."""

    participant: str
    reason: str


@dataclasses.dataclass(frozen=True, slots=True)
class EffectResult:
    """A test that was computed.

    Attributes:
        name: what the tables call it.
        formula: the model, in words or as a formula.
        role: primary, sensitivity, or shown for comparison only.
        statistic_name: "F", "t" or "V".
        statistic: its value.
        df1: numerator degrees of freedom; None where there are none.
        df2: denominator degrees of freedom; None where there are none.
        p: two-sided probability under the null hypothesis.
        estimate: the difference, in the measure's unit; None where there is no single one.
        interval: its confidence interval.
        effects: standardised effects, the main one first.
        rows: rows of data that entered.
        participants: who entered, sorted.
        excluded: who did not, and why.
        note: what a reader must know, or empty.
    """

    name: str
    formula: str
    role: Role
    statistic_name: str
    statistic: float
    df1: float | None
    df2: float | None
    p: float
    estimate: float | None
    interval: Interval | None
    effects: tuple[EffectSize, ...]
    rows: int
    participants: tuple[str, ...]
    excluded: tuple[Excluded, ...] = ()
    note: str = ""

    def effect(self, name: str) -> EffectSize:
        """Return the effect size of that name.

        Raises:
            KeyError: this test does not give it.
        """
        for effect in self.effects:
            if effect.name == name:
                return effect
        raise KeyError(name)


@dataclasses.dataclass(frozen=True, slots=True)
class Refusal:
    """A test that was not computed because its result would mean nothing."""

    name: str
    reason: str
    excluded: tuple[Excluded, ...] = ()


Outcome = EffectResult | Refusal
