"""What the analysis takes from a recorded protocol.

Protocols are read as they were recorded, whatever version wrote them: a key that is missing
or of another kind is passed over, never an error.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any

from analysis.factors import Crossing, crossed_settings
from analysis.instruments import Instrument, Item, instruments
from analysis.recordings import StudyRecordings
from study.events.codes import Phase


@dataclasses.dataclass(frozen=True, slots=True)
class Condition:
    """A condition as figures and tables call it."""

    name: str
    label: str
    allocation: str


@dataclasses.dataclass(frozen=True, slots=True)
class ExclusionRule:
    """A declared rule: participants below a threshold are left out."""

    name: str
    measure: str
    at_least: float
    reason: str


@dataclasses.dataclass(frozen=True, slots=True)
class TrialExclusionRule:
    """A declared rule: trials in which one of these deviations happened are left out."""

    name: str
    deviations: frozenset[str]
    reason: str


@dataclasses.dataclass(frozen=True, slots=True)
class ProtocolFacts:
    """What the report says of the protocol.

    Attributes:
        title: the study's title.
        conditions: those of phase three, the reference first.
        instruments: the questionnaires, by name.
        items: their items, by id.
        assumptions: key path to reason, in the protocol's order.
        exclusions: rules by which participants are left out.
        trial_exclusions: rules by which single trials are left out.
        planned_participants: how many were planned; None if not stated.
        planned_trials: trials planned in each condition; None if not stated.
        crossing: the factors that the conditions cross; None if they cross none.
        planned_conditions: how many conditions the protocol declares, run or not.
        equivalence_bound: smallest difference of interest, points; None if not stated.
    """

    title: str
    conditions: tuple[Condition, ...]
    instruments: Mapping[str, Instrument]
    items: Mapping[str, Item]
    assumptions: tuple[tuple[str, str], ...]
    exclusions: tuple[ExclusionRule, ...]
    trial_exclusions: tuple[TrialExclusionRule, ...]
    planned_participants: int | None
    planned_trials: int | None
    equivalence_bound: float | None = None
    planned_conditions: int = 0
    crossing: Crossing | None = None

    @property
    def levels(self) -> tuple[str, ...]:
        """Names of the conditions, the reference first."""
        return tuple(condition.name for condition in self.conditions)

    def label(self, name: str) -> str:
        """Return a condition's label; its name where the protocol gives none."""
        return next((c.label for c in self.conditions if c.name == name), name)


def protocol_facts(study: StudyRecordings) -> ProtocolFacts:
    """Gather the facts from the first session's protocol and the conditions in the data."""
    session = study.first
    protocol = session.protocol
    about = _table(protocol.get("study"))
    asked = instruments(session)
    conditions = _conditions(study)
    return ProtocolFacts(
        title=str(about.get("title") or about.get("name") or "A study without a title"),
        conditions=conditions,
        instruments=asked,
        items=_items(asked),
        assumptions=tuple(_flat(_table(protocol.get("assumptions")))),
        exclusions=tuple(_exclusions(protocol)),
        trial_exclusions=tuple(_trial_exclusions(protocol)),
        planned_participants=_whole_or_none(about.get("planned_participants")),
        planned_trials=_whole_or_none(_table(protocol.get("phase_three")).get("trials")),
        equivalence_bound=_number_or_none(
            _table(protocol.get("analysis")).get("equivalence_bound")
        ),
        planned_conditions=len(_declared(protocol)),
        crossing=_crossing(protocol, [condition.name for condition in conditions]),
    )


def _conditions(study: StudyRecordings) -> tuple[Condition, ...]:
    found: dict[str, str] = {}
    for session in study.sessions:
        for trial in session.trials.values():
            if trial.phase == Phase.THREE and trial.condition:
                found.setdefault(trial.condition, trial.allocation)
    entries = _declared(study.first.protocol)
    labels = {str(e["name"]): str(e.get("label") or e["name"]) for e in entries if "name" in e}
    names = [name for name in labels if name in found]
    names += sorted(set(found) - set(names))
    conditions = [Condition(n, _capital(labels.get(n, n)), found[n]) for n in names]
    # The participant's own choice is what assistance is compared with.
    conditions.sort(key=lambda condition: condition.allocation != "manual")
    return tuple(conditions)


def _declared(protocol: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    declared = protocol.get("conditions")
    return [_table(item) for item in declared] if isinstance(declared, list) else []


def _crossing(protocol: Mapping[str, Any], names: list[str]) -> Crossing | None:
    """Return what is crossed by the conditions that ran, where the protocol declares them all."""
    entries = {str(entry.get("name")): entry for entry in _declared(protocol)}
    if not all(name in entries for name in names):
        return None
    return crossed_settings([entries[name] for name in names])


def _items(asked: Mapping[str, Instrument]) -> dict[str, Item]:
    items: dict[str, Item] = {}
    for instrument in asked.values():
        for item in instrument.items:
            items.setdefault(item.name, item)
    return items


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    for key, value in table.items():
        path = f"{prefix}{key}"
        if isinstance(value, Mapping):
            yield from _flat(value, f"{path}.")
        else:
            yield path, str(value)


def _exclusions(protocol: Mapping[str, Any]) -> Iterator[ExclusionRule]:
    declared = protocol.get("exclusions")
    for entry in declared if isinstance(declared, list) else []:
        rule = _table(entry)
        threshold = rule.get("at_least")
        if rule.get("measure") and isinstance(threshold, int | float):
            yield ExclusionRule(
                name=str(rule.get("name", rule["measure"])),
                measure=str(rule["measure"]),
                at_least=float(threshold),
                reason=str(rule.get("reason", "")),
            )


def _trial_exclusions(protocol: Mapping[str, Any]) -> Iterator[TrialExclusionRule]:
    declared = protocol.get("trial_exclusions")
    for entry in declared if isinstance(declared, list) else []:
        rule = _table(entry)
        codes = rule.get("deviations")
        if isinstance(codes, list) and codes:
            named = frozenset(str(code) for code in codes)
            name = str(rule.get("name", "unnamed"))
            yield TrialExclusionRule(name, named, str(rule.get("reason", "")))


def _table(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _whole_or_none(value: object) -> int | None:
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def _number_or_none(value: object) -> float | None:
    known = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if known else None  # type: ignore[arg-type]


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
