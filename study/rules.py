"""Tables of files that people write, with the rules that their settings keep among one another.

A rule looks at a whole table; it is a function that yields a problem in words. Where something
in the table is wrong by itself, the rule looks at the rest: asking for what is wrong ends the
rule, and only that rule.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from types import UnionType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError, model_validator

Entry = TypeVar("Entry")
Place = tuple[int | str, ...]
_KEY = "[key]"
"""The step that pydantic adds to the place of a key that is wrong."""
_SHORT = ("too_short", "too_long")


class NotRightError(Exception):
    """A rule asked for what is wrong by itself: it has nothing to say before that is mended."""


class _Wrong:
    """Stands in a list or table for an entry that is wrong; nothing can be asked of it."""

    def __getattr__(self, name: str) -> object:
        raise NotRightError(name)


WRONG: Any = _Wrong()


class _WrongName(str):
    """A key that is no allowed name, so that nobody knows which is meant."""

    __slots__ = ()


class Part(BaseModel):
    """A table of a file: unknown keys are errors, and so is what breaks its rules.

    Attributes:
        rules: each is called with the table and yields problems. It may be called with a table of
            which some settings are wrong; those are not there.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    rules: ClassVar[tuple[Callable[[Any], Iterator[str]], ...]] = ()

    @model_validator(mode="after")
    def _keep_rules(self) -> Self:
        problems = list(broken(self.rules, self))
        if problems:
            raise ValueError("\n".join(problems))
        return self

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            if name in type(self).model_fields:
                raise NotRightError(name)
            return super().__getattr__(name)


def broken(rules: Iterable[Callable[..., Iterator[str]]], *parts: object) -> Iterator[str]:
    """Say which rules are broken by what is right in ``parts``, which they are called with."""
    for rule in rules:
        with suppress(NotRightError):
            yield from rule(*parts)


def right(entries: Iterable[Entry], *names: str) -> list[Entry]:
    """Return the entries that are right, as far as the settings called ``names`` go."""
    return [
        entry
        for entry in entries
        if entry is not WRONG and all(name in vars(entry) for name in names)
    ]


def right_settings(part: BaseModel) -> dict[str, Any]:
    """Return what is right in a table, by name."""
    return dict(vars(part))


def known_names(table: Mapping[str, object]) -> list[str]:
    """Return the keys of a table.

    Raises:
        NotRightError: one is no allowed name; what is asked for may be meant by it.
    """
    if any(isinstance(name, _WrongName) for name in table):
        raise NotRightError
    return list(table)


class RightIn:
    """What is right in a file that something is wrong in.

    Args:
        errors: pydantic's, with places in the file.
        misspelt: places of settings that an unknown key is meant as.

    Attributes:
        told: places of tables and what is wrong there, by those rules that pydantic left out
            since something in the table is wrong.
    """

    def __init__(self, errors: Sequence[Mapping[str, Any]], misspelt: Iterable[Place]) -> None:
        self._errors = [(tuple(error["loc"]), error["type"]) for error in errors]
        self._misspelt = frozenset(misspelt)
        self.told: list[tuple[Place, str]] = []

    def value(self, kind: Any, given: object, at: Place = ()) -> Any:  # noqa: ANN401 - any type
        """Return a value as far as it is right; `WRONG` if nothing is.

        Args:
            kind: its type, as in an annotation.
            given: as JSON has it.
            at: where it stands.
        """
        depth = len(at)
        errors = [
            (place[depth:], what)
            for place, what in self._errors
            if place[:depth] == at and place[depth : depth + 1] != (_KEY,)
        ]
        if not errors:
            try:
                return TypeAdapter[Any](kind).validate_json(json.dumps(given), strict=True)
            except ValidationError:
                return WRONG
        here = {what for place, what in errors if not place}
        inside = [place for place, _ in errors if place]
        models = list(_models_in(kind))
        if isinstance(given, dict) and models:
            if len(models) == 1:
                return self._table(models[0], given, at, has_wrong=bool(inside))
            # Of several models pydantic adds the tag of the one that is meant to the place.
            for model in models:
                for tag in _tags_of(model).intersection(place[0] for place in inside):
                    return self._table(model, given, (*at, tag), has_wrong=True)
            return WRONG
        origin, kinds = get_origin(kind), get_args(kind)
        if isinstance(given, list) and kinds[1:] == (...,) and not here.intersection(_SHORT):
            return tuple(self.value(kinds[0], each, (*at, n)) for n, each in enumerate(given))
        if isinstance(given, dict) and origin is dict:
            wrong = {place[0] for place in inside if place[1:] == (_KEY,)}
            return {
                _WrongName(name) if name in wrong else name: self.value(kinds[1], each, (*at, name))
                for name, each in given.items()
            }
        return WRONG

    def _table(
        self, model: type[BaseModel], given: dict[str, Any], at: Place, *, has_wrong: bool
    ) -> BaseModel:
        settings: dict[str, Any] = {}
        for name, field in model.model_fields.items():
            if name in given:
                settings[name] = self.value(field.annotation, given[name], (*at, name))
            elif not field.is_required() and (*at, name) not in self._misspelt:
                settings[name] = field.get_default(call_default_factory=True)
        settings = {name: value for name, value in settings.items() if value is not WRONG}
        part = model.model_construct(**settings)
        for name in model.model_fields.keys() - settings.keys():
            vars(part).pop(name, None)
        # Where no setting is wrong by itself pydantic has looked at the rules.
        if has_wrong and issubclass(model, Part):
            self.told += [(at, problem) for problem in broken(model.rules, part)]
        return part


def _models_in(kind: Any) -> Iterator[type[BaseModel]]:  # noqa: ANN401 - a type form
    """The models that a table may be: of ``Part``, ``Part | None`` or ``One | Other``."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        yield kind
    elif get_origin(kind) in (Union, UnionType):
        for each in get_args(kind):
            yield from _models_in(each)


def _tags_of(model: type[BaseModel]) -> set[str]:
    """What tells a model from the others of a union: a setting that can be one text only."""
    kinds = [field.annotation for field in model.model_fields.values()]
    return {get_args(kind)[0] for kind in kinds if get_origin(kind) is Literal}
