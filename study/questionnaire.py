"""Instruments: items, their scales, the check of an answer, and how answers are scored."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from study.errors import ProtocolError
from study.toml_text import parse_toml
from study.validation import NAME_PATTERN, validation_problems

Kind = Literal["scale", "choice", "number", "text"]
Option = Annotated[str, Field(min_length=1, max_length=80)]
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
        if (self.kind == "choice") != bool(self.options) or len(self.options) == 1:
            wanted = (
                f'a "choice" has at least two, {len(self.options)} given'
                if self.kind == "choice"
                else f'a "{self.kind}" has none; only a "choice" has'
            )
            raise ValueError(f"options: {wanted}")
        if self.optional and self.kind != "text":
            raise ValueError("optional: only a free text may stay open")
        if self.least > self.most:
            raise ValueError(f"least: {self.least} given; it must not exceed most, {self.most}")
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
        if self.high <= self.low:
            raise ValueError(f"high: {self.high} given; it must exceed low, {self.low}")
        if (self.high - self.low) % self.step:
            raise ValueError(
                f"step: {self.step} given; from {self.low} it does not lead to {self.high}"
            )
        for labels in (self.labels, *(item.labels or {} for item in self.items)):
            for value in labels:
                if not value.isdigit() or not self.accepts(int(value)):
                    raise ValueError(
                        f'labels: "{value}" is no value from {self.low} to {self.high}'
                    )
        ids = [item.id for item in self.items]
        if len(set(ids)) != len(ids):
            raise ValueError(f"items: an id is given twice: {', '.join(ids)}")
        on_scale = [item.id for item in self.items if item.kind == "scale"]
        for scale in self.scales:
            for given in (*scale.items, *scale.reverse):
                if given not in on_scale:
                    raise ValueError(f'scales: "{given}" is no item on the scale')
        return self

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


def parse_questionnaire(text: str, source: str) -> Questionnaire:
    """Read a questionnaire from the text of a TOML file.

    Raises:
        ProtocolError: one message a problem.
    """
    try:
        return Questionnaire.model_validate(parse_toml(text, source))
    except ValidationError as error:
        raise ProtocolError(source, list(validation_problems(error, Questionnaire))) from error
