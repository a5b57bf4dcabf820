"""Where the data come from, in words: it stands on every output."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from analysis.recordings import Session, StudyRecordings, operator_parameters

STUDY_SEED = "study_seed"
"""Among a simulated operator's parameters: the seed of all its study's sessions."""


@dataclasses.dataclass(frozen=True, slots=True)
class DataLabel:
    """The origin of the data.

    Attributes:
        simulated: whether any participant is simulated.
        short: two or three words, for the contents column.
        line: kind, number and seeds: in each row of every table.
        parameters: a simulated operator's parameters, (name, value or range) in order of name.
    """

    simulated: bool
    short: str
    line: str
    parameters: tuple[tuple[str, str], ...]


def data_label(study: StudyRecordings) -> DataLabel:
    """Describe who produced the recordings."""
    simulated = [s for s in study.sessions if s.opened.operator_kind == "simulated"]
    people = len(study.sessions) - len(simulated)
    if not simulated:
        count = "1 person" if people == 1 else f"{people} persons"
        return DataLabel(simulated=False, short=count, line=count, parameters=())
    line = f"Simulated participants, N = {len(simulated)}, {_seeds(simulated)}"
    short = f"Simulated participants, N = {len(simulated)}"
    if people:
        mixture = f"; {people} persons" if people > 1 else "; 1 person"
        line, short = line + mixture, short + mixture
    given: dict[str, list[Any]] = {}
    for session in simulated:
        for name, value in _flat(operator_parameters(session)):
            given.setdefault(name, []).append(value)
    parameters = tuple((name, _range(values)) for name, values in sorted(given.items()))
    return DataLabel(simulated=True, short=short, line=line, parameters=parameters)


def _seeds(simulated: Sequence[Session]) -> str:
    """Name the seed that made a simulated study, or else the range of its sessions' seeds."""
    made_by = {str(operator_parameters(session).get(STUDY_SEED, "")) for session in simulated}
    if len(made_by) == 1 and (seed := made_by.pop()):
        return f"study seed {seed}"
    seeds = sorted(session.opened.seed for session in simulated)
    return f"seed {seeds[0]}" if seeds[0] == seeds[-1] else f"seeds {seeds[0]} to {seeds[-1]}"


def _flat(value: dict[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    for name, entry in value.items():
        if isinstance(entry, dict):
            pairs += _flat(entry, f"{prefix}{name}.")
        else:
            pairs.append((f"{prefix}{name}", entry))
    return pairs


def _range(values: list[Any]) -> str:
    """Return the one value, or the range or the list of those that occur."""
    if all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        low, high = min(values), max(values)
        return f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
    distinct = sorted({str(v) for v in values})
    shown = ", ".join(distinct[:4])
    return shown if len(distinct) <= 4 else f"{shown}, ... ({len(distinct)} values)"
