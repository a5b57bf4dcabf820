"""Questionnaires: items, scale, and the check of an answer."""

from __future__ import annotations

import tomllib

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from study.errors import ProtocolError
from study.validation import NAME_PATTERN, validation_problems


class Item(BaseModel):
    """One sentence to agree with."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str = Field(pattern=NAME_PATTERN, description="id in the data")
    text: str = Field(min_length=1, max_length=300, description="the sentence")


class Questionnaire(BaseModel):
    """Items on one common scale.

    Attributes:
        labels: words for some of the values, in order of value.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(pattern=NAME_PATTERN, description="the file's stem")
    version: int = Field(ge=1, description="raised with every change of wording")
    title: str = Field(min_length=1, max_length=80, description="headline of the screen")
    prompt: str = Field(min_length=1, max_length=200, description="instruction under it")
    low: int = Field(ge=0, le=9, description="smallest answer")
    high: int = Field(ge=1, le=9, description="largest answer")
    labels: dict[str, str] = Field(description="value to words")
    items: tuple[Item, ...] = Field(min_length=1, max_length=4, description="the sentences")

    @model_validator(mode="after")
    def _check(self) -> Questionnaire:
        if self.high <= self.low:
            raise ValueError(f"high: {self.high} given; it must exceed low, {self.low}")
        for value in self.labels:
            if not value.isdigit() or not self.low <= int(value) <= self.high:
                raise ValueError(f'labels: "{value}" is no value from {self.low} to {self.high}')
        ids = [item.id for item in self.items]
        if len(set(ids)) != len(ids):
            raise ValueError(f"items: an id is given twice: {', '.join(ids)}")
        return self

    def value_labels(self) -> tuple[tuple[int, str], ...]:
        """Return (value, words) pairs in order of value."""
        return tuple(sorted((int(value), words) for value, words in self.labels.items()))

    def accepts(self, value: int) -> bool:
        """Whether ``value`` is an answer on this scale."""
        return self.low <= value <= self.high


def parse_questionnaire(text: str, source: str) -> Questionnaire:
    """Read a questionnaire from the text of a TOML file.

    Raises:
        ProtocolError: one message a problem.
    """
    try:
        return Questionnaire.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ProtocolError(source, [f"not TOML: {error}"]) from error
    except ValidationError as error:
        raise ProtocolError(source, list(validation_problems(error, Questionnaire))) from error
