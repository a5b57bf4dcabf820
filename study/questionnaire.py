"""Instruments: items, their scales, the check of an answer, and how answers are scored."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

from pydantic import Field

from study.errors import ProtocolError
from study.rules import Part, broken, right, right_settings
from study.toml_text import parse_toml
from study.validation import NAME_PATTERN, checked

Kind = Literal["scale", "choice", "number", "text"]
Option = Annotated[str, Field(min_length=1, max_length=80)]
TENS_FROM = 90
"""Highest value of a scale from which on a digit alone counts for tens."""
LONGEST_TEXT = 400
LARGEST_NUMBER = 999_999


class Item(Part):
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

    def _options_of_a_choice(self) -> Iterator[str]:
        if (self.kind == "choice") != bool(self.options) or len(self.options) == 1:
            wanted = (
                f'a "choice" has at least two, {len(self.options)} given'
                if self.kind == "choice"
                else f'a "{self.kind}" has none; only a "choice" has'
            )
            yield f"options: {wanted}"

    def _open_text(self) -> Iterator[str]:
        if self.optional and self.kind != "text":
            yield "optional: only a free text may stay open"

    def _least_to_most(self) -> Iterator[str]:
        if self.least > self.most:
            yield f"least: {self.least} given; it must not exceed most, {self.most}"

    rules = (_options_of_a_choice, _open_text, _least_to_most)


class Scale(Part):
    """What is computed from the answers.

    An item answered v on a scale from low to high counts as v, or as low + high - v if it is
    listed in ``reverse``. "mean" and "sum" are of those; "percent" is the mean of
    (v - low) / (high - low), times 100.
    """

    name: str = Field(pattern=NAME_PATTERN, description="name in the data")
    method: Literal["mean", "sum", "percent"] = Field(description="how items are put together")
    items: tuple[str, ...] = Field(default=(), description="ids; default: all items on the scale")
    reverse: tuple[str, ...] = Field(default=(), description="ids of items worded the other way")


class Questionnaire(Part):
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

    def _range(self) -> Iterator[str]:
        if self.high <= self.low:
            yield f"high: {self.high} given; it must exceed low, {self.low}"
        elif (self.high - self.low) % self.step:
            yield f"step: {self.step} given; from {self.low} it does not lead to {self.high}"

    def _labels(self) -> Iterator[str]:
        yield from self._wrong_labels("labels", self.labels)

    def _labels_of_items(self) -> Iterator[str]:
        for item in right(self.items, "id", "labels"):
            yield from broken([self._wrong_labels], f"items: {item.id}: labels", item.labels or {})

    def _wrong_labels(self, path: str, labels: Mapping[str, str]) -> Iterator[str]:
        numbers = [value for value in labels if value.isdecimal()]
        for value in labels:
            if value not in numbers:
                yield f'{path}: "{value}" is no whole number'
        if any(self._range()):
            # Which values there are is to be mended first.
            return
        for value in numbers:
            if not self.accepts(int(value)):
                yield f'{path}: "{value}" is no value from {self.low} to {self.high}'

    def _ids_once(self) -> Iterator[str]:
        ids = [item.id for item in right(self.items, "id")]
        if len(set(ids)) != len(ids):
            yield f"items: an id is given twice: {', '.join(ids)}"

    def _scored(self) -> Iterator[str]:
        # All ids have to be right: the one that is not may be the one that a scale means.
        answered_otherwise = [item for item in right(self.items, "kind") if item.kind != "scale"]
        known = {item.id for item in self.items} - {item.id for item in answered_otherwise}
        for scale in right(self.scales):
            named = right_settings(scale)
            ids = (*named.get("items", ()), *named.get("reverse", ()))
            for given in dict.fromkeys(right(ids)):
                if given not in known:
                    yield f'scales: "{given}" is no item on the scale'

    rules = (_range, _labels, _labels_of_items, _ids_once, _scored)

    def value_labels(self, item: Item | None = None) -> tuple[tuple[int, str], ...]:
        """Return (value, words) pairs in order of value, of an item or of all."""
        labels = self.labels if item is None or item.labels is None else item.labels
        return tuple(sorted((int(value), words) for value, words in labels.items()))

    def accepts(self, value: int) -> bool:
        """Whether ``value`` is an answer on the common scale."""
        return self.low <= value <= self.high and (value - self.low) % self.step == 0

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
    found = checked(Questionnaire, parse_toml(text, source))
    problems = [*found.problems, *(broken([_named_as_file], found.seen, name) if name else ())]
    if problems or found.made is None:
        raise ProtocolError(source, problems)
    return found.made


def _named_as_file(questionnaire: Questionnaire, name: str) -> Iterator[str]:
    if questionnaire.name != name:
        yield f'name: "{questionnaire.name}" given; must be the file\'s, "{name}"'
