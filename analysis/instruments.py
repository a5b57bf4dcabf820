"""Questionnaires as a session recorded them: their items, and how answers become scores.

A recording carries the whole text of what was asked (`SessionOpened.questionnaires_json`), so that
scores follow from it alone. What is missing or of another kind is passed over, never an error.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping
from typing import Any

from analysis.recordings import Session

METHODS = ("mean", "sum", "percent")


@dataclasses.dataclass(frozen=True, slots=True)
class Item:
    """One item of a questionnaire.

    Attributes:
        name: its id.
        text: the sentence.
        low, high: of the scale that its questionnaire answers on.
        labels: value to words.
        kind: "scale", "choice", "number" or "text".
        questionnaire: whose it is.
    """

    name: str
    text: str
    low: int
    high: int
    labels: Mapping[str, str]
    kind: str = "scale"
    questionnaire: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class Scale:
    """What is computed from answers: their "mean", "sum" or "percent" of the range.

    Attributes:
        name: its name in the data.
        method: how items are put together.
        items: ids of the items that enter.
        reverse: ids of those worded the other way: v counts as low + high - v.
    """

    name: str
    method: str
    items: tuple[str, ...]
    reverse: frozenset[str]


@dataclasses.dataclass(frozen=True, slots=True)
class Instrument:
    """A questionnaire: its items on the scale from low to high, and its scales."""

    name: str
    version: int
    title: str
    low: int
    high: int
    items: tuple[Item, ...]
    scales: tuple[Scale, ...]

    def scale(self, name: str) -> Scale | None:
        """Return the scale of that name; None if it has none."""
        return next((scale for scale in self.scales if scale.name == name), None)

    def directed(self, scale: Scale, answers: Mapping[str, int]) -> list[float] | None:
        """Return the scale's answers with reversed items turned round; None if one is missing."""
        if not all(item in answers for item in scale.items):
            return None
        return [
            float(self.low + self.high - answers[item] if item in scale.reverse else answers[item])
            for item in scale.items
        ]

    def score(self, scale: Scale, answers: Mapping[str, int]) -> float | None:
        """Return a scale's score by its own rule; None if an answer is missing."""
        values = self.directed(scale, answers)
        if not values:
            return None
        total = sum(values)
        if scale.method == "sum":
            return total
        if scale.method == "mean":
            return total / len(values)
        # In the order of the session's own arithmetic, so that the last bit agrees.
        return 100 * (total - self.low * len(values)) / ((self.high - self.low) * len(values))

    def reach(self, scale: Scale) -> tuple[float, float]:
        """Return the least and the largest score possible."""
        if scale.method == "percent":
            return 0.0, 100.0
        times = len(scale.items) if scale.method == "sum" else 1
        return float(self.low * times), float(self.high * times)


def instruments(session: Session) -> dict[str, Instrument]:
    """Return what a session was asked, by name."""
    try:
        asked = json.loads(session.opened.questionnaires_json or "{}")
    except (ValueError, RecursionError):
        return {}
    return {str(name): _instrument(str(name), _table(value)) for name, value in _sorted(asked)}


def _instrument(name: str, given: Mapping[str, Any]) -> Instrument:
    low, high = _whole(given.get("low"), 1), _whole(given.get("high"), 7)
    labels = {str(key): str(words) for key, words in _table(given.get("labels")).items()}
    items = []
    for entry in _tables(given.get("items")):
        if entry.get("id") and entry.get("text"):
            kind = str(entry.get("kind") or "scale")
            made = Item(str(entry["id"]), str(entry["text"]), low, high, labels, kind, name)
            items.append(made)
    on_scale = tuple(item.name for item in items if item.kind == "scale")
    return Instrument(
        name=name,
        version=_whole(given.get("version"), 0),
        title=str(given.get("title") or name),
        low=low,
        high=high,
        items=tuple(items),
        scales=tuple(_scales(given, on_scale)) if high > low else (),
    )


def _scales(given: Mapping[str, Any], on_scale: tuple[str, ...]) -> Iterator[Scale]:
    for entry in _tables(given.get("scales")):
        named, reverse = entry.get("items"), entry.get("reverse")
        items = tuple(str(item) for item in named) if isinstance(named, list) else ()
        turned = frozenset(str(i) for i in reverse) if isinstance(reverse, list) else frozenset()
        if entry.get("name") and entry.get("method") in METHODS and (items or on_scale):
            yield Scale(str(entry["name"]), str(entry["method"]), items or on_scale, turned)


def _sorted(value: object) -> list[tuple[Any, Any]]:
    return sorted(_table(value).items())


def _table(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _tables(value: object) -> list[Mapping[str, Any]]:
    return [_table(entry) for entry in value] if isinstance(value, list) else []


def _whole(value: object, otherwise: int) -> int:
    return value if isinstance(value, int) and not isinstance(value, bool) else otherwise
