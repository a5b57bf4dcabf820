"""Factors that conditions cross: found in their settings by the rule `crossed_settings`.

The rule. A *setting* of a condition is its allocation, scorer, robots (fleet size), dwell or view.
Conditions cross factors where two settings, or three, take each combination of their values exactly
once over the conditions, two values each at least, and every other setting that differs follows
from one of them alone: a dwell that only assisted conditions have follows from the allocation. The
fewest settings that do are the factors, in the order above. If no settings do, conditions are
levels of one factor. So whatever differs between two cells is told by the factors, and a setting
that differs on the side is never taken for an effect of theirs.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from typing import Any

SETTINGS: Mapping[str, str] = {
    "allocation": "Allocation",
    "scorer": "Scorer",
    "robots": "Fleet size",
    "dwell": "Dwell",
    "view": "View",
}
"""Settings of a condition in a protocol, and what the report calls them as factors."""
DEFAULTS: Mapping[str, object] = {"scorer": "", "dwell": 0}
MOST_FACTORS = 3


@dataclasses.dataclass(frozen=True, slots=True)
class Factor:
    """One factor.

    Attributes:
        name: the setting that makes it.
        label: what the report calls it.
        levels: its values as text, the reference first.
        level_labels: what the report calls them.
    """

    name: str
    label: str
    levels: tuple[str, ...]
    level_labels: tuple[str, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class Crossing:
    """Conditions as cells of crossed factors.

    Attributes:
        factors: two or three.
        cells: each condition's level of each factor, in the order of the factors.
    """

    factors: tuple[Factor, ...]
    cells: Mapping[str, tuple[str, ...]]

    @property
    def levels(self) -> dict[str, tuple[str, ...]]:
        """Levels of each factor, by its name."""
        return {factor.name: factor.levels for factor in self.factors}

    def condition(self, cell: Sequence[str]) -> str:
        """Return the condition in a cell."""
        return next(name for name, found in self.cells.items() if found == tuple(cell))

    def label(self, effect: str) -> str:
        """Return an effect's name for readers: "allocation:robots" is "Allocation × Fleet size"."""
        known = {factor.name: factor.label for factor in self.factors}
        return " × ".join(known.get(part, part) for part in effect.split(":"))


def crossed_settings(conditions: Sequence[Mapping[str, Any]]) -> Crossing | None:
    """Return the factors that conditions cross; None if they cross none.

    Args:
        conditions: their tables in the protocol, the reference first.
    """
    names = [str(condition.get("name", "")) for condition in conditions]
    values = {
        setting: [_text(condition.get(setting, DEFAULTS.get(setting))) for condition in conditions]
        for setting in SETTINGS
    }
    differing = [setting for setting in SETTINGS if len(set(values[setting])) > 1]
    for size in range(2, MOST_FACTORS + 1):
        for chosen in itertools.combinations(differing, size):
            others = [values[setting] for setting in differing if setting not in chosen]
            if _crosses([values[setting] for setting in chosen], others):
                cells = zip(*(values[setting] for setting in chosen), strict=True)
                factors = tuple(_factor(setting, values[setting]) for setting in chosen)
                return Crossing(factors, dict(zip(names, cells, strict=True)))
    return None


def _crosses(chosen: Sequence[Sequence[str]], others: Sequence[Sequence[str]]) -> bool:
    cells = list(zip(*chosen, strict=True))
    wanted = 1
    for values in chosen:
        wanted *= len(set(values))
    if len(cells) != wanted or len(set(cells)) != wanted:
        return False
    return all(any(_follows(other, values) for values in chosen) for other in others)


def _follows(other: Sequence[str], values: Sequence[str]) -> bool:
    """Return whether one setting is told by another alone."""
    return len(set(zip(values, other, strict=True))) == len(set(values))


def _factor(setting: str, values: Sequence[str]) -> Factor:
    levels = tuple(dict.fromkeys(values))
    if all(level.isdecimal() for level in levels):
        levels = tuple(sorted(levels, key=int))
    return Factor(setting, SETTINGS[setting], levels, tuple(_label(setting, v) for v in levels))


def _label(setting: str, value: str) -> str:
    if setting == "robots":
        return f"{value} robots"
    if setting == "dwell":
        return f"{value} timesteps" if value != "0" else "no dwell"
    words = value.replace("_", " ") or "no scorer"
    return words[:1].upper() + words[1:]


def _text(value: object) -> str:
    return "" if value is None else str(value)
