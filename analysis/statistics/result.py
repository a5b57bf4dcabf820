"""What every statistical test returns: one typed result, or a refusal with its reason.

`Outcome` is `EffectResult | Refusal`. A test of one question returns one Outcome; a model
with several terms returns a dataclass of its own (see its module) that holds an EffectResult
for each term, so that one table can show them all. What has neither statistic nor p (a Bayes
factor, a reliability, a series with one participant left out each time) has a small type of
its own beside its function, and refuses with the same `Refusal`.

How to show an EffectResult:

- `estimate`, `standard_error` and `interval` are in `unit`; an empty unit is the measure's own
  ("points a trial"). A cumulative-link model's is "log odds": never print it as points.
- `statistic_name` is "F", "t", "z", "V", "chi2", ...; `df1` and `df2` are None where there are
  none; they need not be whole numbers. `method` says where they come from ("Kenward-Roger").
- `effects` are in order of importance; each interval states its own level (eta squared: 90 %).
- `p_adjusted` is Holm's over the family that `note` names; None where there is no family.
- `excluded` names participants, `rows_excluded` counts rows of participants that were used.
- `checks` are tests of the assumptions of this test (sphericity, normality): they are shown
  beside it and never decide which test is run.
- `note` is a whole sentence, or empty.
"""

from __future__ import annotations

import dataclasses
from typing import Literal

ALPHA = 0.05
"""Below this p, words say that something differs."""

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

    def within(self, low: float, high: float) -> Interval:
        """Return the part of it between two bounds, as a figure of shares shows it."""
        return Interval(max(low, self.low), min(high, self.high), self.level)


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
class ExcludedRows:
    """Rows that did not enter although their participant did, and why in words."""

    count: int
    reason: str


@dataclasses.dataclass(frozen=True, slots=True)
class Check:
    """A test of an assumption.

    Attributes:
        name: "Mauchly's test of sphericity", ...
        statistic_name: "W", ...
        statistic: its value.
        p: probability if the assumption held; None where the test gives none.
        df: its degrees of freedom; None where there are none.
        note: what it means here, a sentence, or empty.
    """

    name: str
    statistic_name: str
    statistic: float
    p: float | None
    df: float | None = None
    note: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class EffectResult:
    """A test that was computed.

    Attributes:
        name: what the tables call it.
        formula: the model, in words or as a formula.
        role: primary, sensitivity, or shown for comparison only.
        statistic_name: "F", "t", "z", "V", "chi2", ...
        statistic: its value.
        df1: numerator degrees of freedom; None where there are none.
        df2: denominator degrees of freedom; None where there are none.
        p: two-sided probability under the null hypothesis.
        estimate: the difference, in `unit`; None where there is no single one.
        interval: its confidence interval.
        effects: standardised effects, the main one first.
        rows: rows of data that entered.
        participants: who entered, sorted.
        excluded: who did not, and why.
        note: what a reader must know, or empty.
        unit: of estimate, standard error and interval; empty for the measure's own.
        method: how the degrees of freedom or p were found ("Kenward-Roger", "exact"), or empty.
        standard_error: of the estimate; None where there is none.
        p_adjusted: p adjusted over a family (Holm); None where there is no family.
        checks: tests of its assumptions.
        rows_excluded: rows left out of participants who were used.
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
    unit: str = ""
    method: str = ""
    standard_error: float | None = None
    p_adjusted: float | None = None
    checks: tuple[Check, ...] = ()
    rows_excluded: tuple[ExcludedRows, ...] = ()

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
    """A test that was not computed because its result would mean nothing.

    Attributes:
        name: what the tables would have called it.
        reason: why not, in whole sentences.
        excluded: participants left out, and why.
        formula: the model that was not fitted, or empty.
    """

    name: str
    reason: str
    excluded: tuple[Excluded, ...] = ()
    formula: str = ""


Outcome = EffectResult | Refusal
