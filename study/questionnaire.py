"""Instruments: items, their scales, the check of an answer, and how answers are scored."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from study.errors import ProtocolError
from study.toml_text import parse_toml
from study.validation import NAME_PATTERN, Rules, broken_rules, checked

Kind = Literal["scale", "choice", "number", "text"]
Option = Annotated[str, Field(min_length=1, max_length=80)]
TENS_FROM = 90
"""Highest value of a scale from which on a digit alone counts for tens."""
LONGEST_TEXT = 400
LARGEST_NUMBER = 999_999


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Item(_Part):
    """One question: a sentence to agree with, a choice, a number or a free text."""

    id: str = Field(pattern=NAME_PATTERN, description="id in the data")
    text: str = Field(min_length=1, max_length=300, description="the sentence")
    kind: Kind = Field(default="scale", description="how it is answered")
    labels: dict[str, str] | None = Field(
        default=None, description="value to words, where they differ from the instrument's"
    )
    options: tuple[Option, ...] = Field(
        default=(), max_length=6, description="of a choice: the answers; the value is 1, 2, ..."
    )
    least: int = Field(default=0, ge=0, description="of a number: smallest")
    most: int = Field(default=LARGEST_NUMBER, le=LARGEST_NUMBER, description="of a number: largest")
    optional: bool = Field(default=False, description="whether it may stay open; free text only")

    @model_validator(mode="after")
    def _check(self) -> Item:
        problems = []
        if (self.kind == "choice") != bool(self.options) or len(self.options) == 1:
            wanted = (
                f'a "choice" has at least two, {len(self.options)} given'
                if self.kind == "choice"
                else f'a "{self.kind}" has none; only a "choice" has'
            )
            problems.append(f"options: {wanted}")
        if self.optional and self.kind != "text":
            problems.append("optional: only a free text may stay open")
        if self.least > self.most:
            problems.append(f"least: {self.least} given; it must not exceed most, {self.most}")
        if problems:
            raise ValueError("\n".join(problems))
        return self


class Scale(_Part):
    """What is computed from the answers.

    An item answered v on a scale from low to high counts as v, or as low + high - v if it is
    listed in ``reverse``. "mean" and "sum" are of those; "percent" is the mean of
    (v - low) / (high - low), times 100.
    """

    name: str = Field(pattern=NAME_PATTERN, description="name in the data")
    method: Literal["mean", "sum", "percent"] = Field(description="how items are put together")
    items: tuple[str, ...] = Field(default=(), description="ids; default: all items on the scale")
    reverse: tuple[str, ...] = Field(default=(), description="ids of items worded the other way")


class Questionnaire(_Part):
    """Items, most often on one common scale.

    Attributes:
        labels: words for some of the values, in order of value.
    """

    name: str = Field(pattern=NAME_PATTERN, description="the file's stem")
    version: int = Field(ge=1, description="raised with every change of wording or scoring")
    title: str = Field(min_length=1, max_length=80, description="headline of the screen")
    prompt: str = Field(min_length=1, max_length=200, description="instruction under it")
    low: int = Field(default=1, ge=0, le=100, description="smallest answer")
    high: int = Field(default=7, ge=1, le=100, description="largest answer")
    step: int = Field(default=1, ge=1, le=50, description="from one answer to the next")
    labels: dict[str, str] = Field(default_factory=dict, description="value to words")
    items: tuple[Item, ...] = Field(min_length=1, max_length=40, description="the sentences")
    items_per_page: int = Field(default=4, ge=1, le=4, description="questions shown at once")
    scales: tuple[Scale, ...] = Field(default=(), description="what is computed from the answers")
    source: str = Field(default="", max_length=600, description="where it comes from, its terms")

    @model_validator(mode="after")
    def _check(self) -> Questionnaire:
        problems = list(broken_rules(RULES, {n: getattr(self, n) for n in type(self).model_fields}))
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def value_labels(self, item: Item | None = None) -> tuple[tuple[int, str], ...]:
        """Return (value, words) pairs in order of value, of an item or of all."""
        labels = self.labels if item is None or item.labels is None else item.labels
        return tuple(sorted((int(value), words) for value, words in labels.items()))

    def accepts(self, value: int) -> bool:
        """Whether ``value`` is an answer on the common scale."""
        return _accepts(self.low, self.high, self.step, value)

    def takes(self, item: Item, value: int) -> bool:
        """Whether ``value`` is an answer to an item."""
        if item.kind == "choice":
            return 1 <= value <= len(item.options)
        if item.kind == "number":
            return item.least <= value <= item.most
        return item.kind == "scale" and self.accepts(value)

    def scores(self, answers: Mapping[str, int]) -> dict[str, float]:
        """Return the score of each scale.

        Args:
            answers: item to value; every item on the scale is answered.
        """
        found = {}
        for scale in self.scales:
            ids = scale.items or tuple(item.id for item in self.items if item.kind == "scale")
            values = [
                self.low + self.high - answers[name] if name in scale.reverse else answers[name]
                for name in ids
            ]
            total = sum(values)
            if scale.method == "sum":
                found[scale.name] = float(total)
            elif scale.method == "mean":
                found[scale.name] = total / len(values)
            else:
                span = (self.high - self.low) * len(values)
                found[scale.name] = 100 * (total - self.low * len(values)) / span
        return found


def parse_questionnaire(text: str, source: str, *, name: str = "") -> Questionnaire:
    """Read a questionnaire from the text of a TOML file.

    Args:
        text: the file's text.
        source: its name, for messages.
        name: that it must have; empty for any.

    Raises:
        ProtocolError: one message a problem.
    """
    found = checked(Questionnaire, parse_toml(text, source), RULES)
    problems = [*found.problems]
    if "items" in found.wrong or "scales" in found.wrong:
        problems += wrong_names_in(found.raw, found.parts)
    given = found.parts.get("name", name)
    if name and given != name:
        problems.append(f'name: "{given}" given; must be the file\'s, "{name}"')
    if problems or found.made is None:
        raise ProtocolError(source, problems)
    return found.made


def _accepts(low: int, high: int, step: int, value: int) -> bool:
    return low <= value <= high and (value - low) % step == 0


def _range(low: int, high: int, step: int) -> Iterator[str]:
    if high <= low:
        yield f"high: {high} given; it must exceed low, {low}"
    elif (high - low) % step:
        yield f"step: {step} given; from {low} it does not lead to {high}"


def _labels(low: int, high: int, step: int, labels: Mapping[str, str]) -> Iterator[str]:
    if any(_range(low, high, step)):
        # Which values there are is to be mended first.
        return
    for value in labels:
        if not value.isdecimal() or not _accepts(low, high, step, int(value)):
            yield f'labels: "{value}" is no value from {low} to {high}'


def _labels_of_items(low: int, high: int, step: int, items: Sequence[Item]) -> Iterator[str]:
    for item in items:
        for problem in _labels(low, high, step, item.labels or {}):
            yield f"items: {item.id}: {problem}"


def _ids_once(items: Sequence[Item]) -> Iterator[str]:
    yield from _given_twice([item.id for item in items])


def _given_twice(ids: Sequence[str]) -> Iterator[str]:
    if len(set(ids)) != len(ids):
        yield f"items: an id is given twice: {', '.join(ids)}"


def _scored(items: Sequence[Item], scales: Sequence[Scale]) -> Iterator[str]:
    on_scale = [item.id for item in items if item.kind == "scale"]
    for scale in scales:
        for given in dict.fromkeys((*scale.items, *scale.reverse)):
            if given not in on_scale:
                yield f'scales: "{given}" is no item on the scale'


def wrong_names_in(raw: Mapping[str, Any], parts: Mapping[str, Any]) -> Iterator[str]:
    """Say which ids are given twice, and which scales name no item, whatever else is wrong there.

    Args:
        raw: the file, as plain values.
        parts: those that are right; what is in them is looked at already.
    """
    items, scales = _tables(raw.get("items")), _tables(raw.get("scales"))
    ids = [item["id"] for item in items if isinstance(item.get("id"), str)]
    if "items" not in parts:
        yield from _given_twice(ids)
    if len(ids) < len(items) or not all(re.fullmatch(NAME_PATTERN, each) for each in ids):
        # One of them may be what is meant.
        return
    for scale in scales:
        named = [scale[key] for key in ("items", "reverse") if isinstance(scale.get(key), list)]
        known = [name for names in named for name in names if isinstance(name, str)]
        for given in dict.fromkeys(known):
            if given not in ids:
                yield f'scales: "{given}" is no item on the scale'


def _tables(given: object) -> list[dict[str, Any]]:
    """Return the tables of a list that may be anything."""
    return [each for each in given if isinstance(each, dict)] if isinstance(given, list) else []


RULES: Rules = (
    (("low", "high", "step"), _range),
    (("low", "high", "step", "labels"), _labels),
    (("low", "high", "step", "items"), _labels_of_items),
    (("items",), _ids_once),
    (("items", "scales"), _scored),
)
