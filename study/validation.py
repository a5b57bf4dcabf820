"""What pydantic finds wrong, in the words of whoever wrote the file."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Generic, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from study.rules import RightIn
from study.spelling import closest

Made = TypeVar("Made", bound=BaseModel)

NAME_PATTERN = r"^[a-z][a-z0-9_]{0,39}$"
"""Names that stand in files' names and in data."""
_EXPECTED = {
    "greater_than_equal": "{ge} or more",
    "greater_than": "more than {gt}",
    "less_than_equal": "{le} or less",
    "less_than": "less than {lt}",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "finite_number": "a finite number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "string_type": 'text, in "quotes"',
    "string_too_short": "{min_length} characters or more",
    "string_too_long": "{max_length} characters or less",
    "too_short": "{min_length} entries or more",
    "too_long": "{max_length} entries or less",
    "tuple_type": "a list, in [brackets]",
    "list_type": "a list, in [brackets]",
    "dict_type": "a table of keys and values",
    "model_type": "a table of keys and values",
}
"""What is allowed instead, by pydantic's kind of error and in terms of its context."""
_NO_STEPS = ("function-", "[")
"""What pydantic has in the places of errors that stands in no file."""
_NOT_THERE = ("missing", "tuple_type", "list_type", "dict_type", "model_type")
"""Kinds of errors that say that a setting, or all in a table, is not there."""


@dataclasses.dataclass(frozen=True, slots=True)
class Checked(Generic[Made]):
    """What a file says, as far as it is right.

    Attributes:
        raw: the file, as plain values.
        made: the whole; None if anything is wrong with it.
        seen: the whole as far as it is right: asking it for what is wrong ends a rule (see
            `study.rules`).
        problems: in words, what is wrong.
        absent: key paths of settings that the file is yet to have: missing, misspelt, or in what
            is no table.
    """

    raw: dict[str, Any]
    made: Made | None
    seen: Made
    problems: list[str]
    absent: frozenset[str] = frozenset()


def checked(model: type[Made], given: Mapping[str, Any], prefix: str = "") -> Checked[Made]:
    """Check what a file or a table in one says by itself, and go on past what is wrong.

    Args:
        model: what is to be made.
        given: the file as TOML has it.
        prefix: path of the table that was given, if it is not the file.
    """
    # By way of JSON pydantic can be strict ("2" and true are no numbers) and yet take
    # arrays for tuples.
    text = json.dumps(given, default=str)
    raw: dict[str, Any] = json.loads(text)
    try:
        made = model.model_validate_json(text, strict=True)
    except ValidationError as error:
        details = _with_entries_of_long_lists(error.errors(), model, raw)
        problems = list(validation_problems(details, model, prefix, given))
        found = RightIn(details, _meant(details, model))
        seen = found.value(model, raw)
        for place, problem in found.told:
            problems.append(_said(_path(place, prefix, given), problem))
        return Checked(raw, None, seen, problems, frozenset(_absent(details, model, given)))
    return Checked(raw, made, made, [])


def _absent(details: list[Any], model: type[BaseModel], given: object) -> Iterator[str]:
    """Yield the key paths of settings that a file is yet to have."""
    places = list(_meant(details, model))
    for item in details:
        place = tuple(_in_file(item["loc"]))
        if item["type"] in _NOT_THERE:
            places.append(place)
        if place[-1:] == ("name",) and isinstance(place[-2:][0], int):
            # Nothing in the list can be called by its name before it has the right one.
            places.append(place[:-2])
    for place in places:
        yield ".".join(_steps(list(place), given))


def _with_entries_of_long_lists(
    details: list[Any], model: type[BaseModel], raw: dict[str, Any]
) -> list[Any]:
    """Add what is wrong with the entries of lists that are too long; pydantic leaves them out."""
    long = [item for item in details if item["type"] == "too_long"]
    if not long:
        return details
    cut = json.loads(json.dumps(raw))
    for item in long:
        entries = cut
        for step in _in_file(item["loc"]):
            entries = _inside(entries, step)
        if isinstance(entries, list):
            del entries[item["ctx"]["max_length"] :]
    try:
        model.model_validate_json(json.dumps(cut), strict=True)
    except ValidationError as error:
        # What is wrong with all of a table that holds such a list comes from the cut.
        holders = [item["loc"][:steps] for item in long for steps in range(len(item["loc"]))]
        known = [item["loc"] for item in details]
        found = _with_entries_of_long_lists(error.errors(), model, cut)
        return details + [item for item in found if item["loc"] not in (*holders, *known)]
    return details


def validation_problems(
    details: list[Any], model: type[BaseModel], prefix: str = "", given_file: object = None
) -> Iterator[str]:
    """Translate pydantic's errors: key path, what was given, what is allowed, nearest name.

    Args:
        details: pydantic's errors.
        model: what was to be made.
        prefix: path of the table that was given, if it is not the file.
        given_file: what was given; entries of lists are called by their names in it.
    """
    misspelt = set(_meant(details, model))
    for item in details:
        location = _in_file(item["loc"])
        path = _path(location, prefix, given_file)
        kind, given = item["type"], item["input"]
        if kind == "too_short" and len(given) >= item["ctx"]["min_length"]:
            # There are enough; what is wrong with some of them is said already.
            continue
        lead = f"{path}: " if path else ""
        if kind == "extra_forbidden":
            allowed = _keys_at(model, location[:-1])
            hint = nearest(str(location[-1]), allowed)
            yield f"{lead}unknown key; {hint}allowed here: {', '.join(allowed) or 'none'}"
        elif kind == "missing":
            if item["loc"] not in misspelt:
                yield f"{lead}missing; {_to_write(model, location)}"
        elif kind == "value_error":
            yield from (_said(path, line) for line in str(item["ctx"]["error"]).splitlines())
        elif kind == "string_pattern_mismatch":
            rule = "a lower-case letter, then up to 39 lower-case letters, digits and _"
            pattern = item["ctx"]["pattern"]
            allowed_words = rule if pattern == NAME_PATTERN else f"must match {pattern}"
            yield f"{lead}{_shown(given)} given; allowed: {allowed_words}"
        elif kind == "union_tag_invalid":
            key = item["ctx"]["discriminator"].strip("'")
            tag, tags = item["ctx"]["tag"], _quoted(item["ctx"]["expected_tags"])
            yield f"{lead}{key} {_shown(tag)} given; allowed: {tags}"
        elif kind == "literal_error":
            choices = [
                word.strip(" '") for word in item["ctx"]["expected"].replace(" or ", ",").split(",")
            ]
            near = closest(str(given), choices)
            hint = f'; did you mean "{near}"?' if near else ""
            yield f"{lead}{_shown(given)} given; allowed: {_quoted(item['ctx']['expected'])}{hint}"
        elif kind in _EXPECTED:
            words = _EXPECTED[kind].format(**_whole(item.get("ctx", {})))
            words = re.sub("^1 (character|entr)(s|ies) ", _of_one, words)
            yield f"{lead}{_shown(given)} given; allowed: {words}"
        else:
            yield f"{lead}{_shown(given)} given; {item['msg'][0].lower()}{item['msg'][1:]}"


def _of_one(found: re.Match[str]) -> str:
    return "1 entry " if found[1] == "entr" else f"1 {found[1]} "


def _to_write(model: type[BaseModel], location: list[int | str]) -> str:
    """Say what to write where a setting is missing: the value, if only one can be."""
    field = _model_at(model, location[:-1]).model_fields.get(str(location[-1]))
    values = get_args(field.annotation) if field and get_origin(field.annotation) is Literal else ()
    if len(values) != 1:
        return "it has to be stated"
    return f"write {location[-1]} = {_shown(values[0])}"


def _meant(details: list[Any], model: type[BaseModel]) -> Iterator[tuple[int | str, ...]]:
    """The places of keys that are missing only because they are misspelt."""
    for item in details:
        if item["type"] == "extra_forbidden":
            *table, key = item["loc"]
            if near := closest(str(key), _keys_at(model, table)):
                yield (*table, near)


def nearest(given: str, known: list[str]) -> str:
    """Return a question that names the known word closest to ``given``; empty if none is."""
    near = closest(given, known)
    return f'did you mean "{near}"? ' if near else ""


def _in_file(location: Iterable[int | str]) -> list[int | str]:
    """Return those steps of a place that stand in the file."""
    return [part for part in location if not str(part).startswith(_NO_STEPS)]


def _said(path: str, problem: str) -> str:
    """Return a rule's problem with the path of its table; it may begin with a setting of that."""
    if not path:
        return problem
    return f"{path}.{problem}" if re.match(r"[a-z_]+: ", problem) else f"{path}: {problem}"


def _path(location: Iterable[int | str], prefix: str, given: object) -> str:
    return ".".join([*([prefix] if prefix else []), *_steps(list(location), given)])


def _steps(location: list[int | str], given: object) -> Iterator[str]:
    """Name each step of a path: an entry of a list by its name if it has one, else by number."""
    here = given
    for place, part in enumerate(location):
        here = _inside(here, part)
        name = here.get("name") if isinstance(part, int) and isinstance(here, dict) else None
        # A name that is itself wrong leads nowhere.
        wrong = location[place + 1 :] == ["name"]
        if isinstance(name, str) and re.fullmatch(NAME_PATTERN, name) and not wrong:
            yield name
        else:
            yield str(part + 1) if isinstance(part, int) else part


def _inside(here: object, part: int | str) -> object:
    if isinstance(here, dict):
        return here.get(part)
    if isinstance(here, list) and isinstance(part, int) and part < len(here):
        return here[part]
    return None


def _shown(given: object) -> str:
    """Return a value about as the file has it, shortened."""
    text = json.dumps(given, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _whole(context: Mapping[str, Any]) -> dict[str, Any]:
    """Return a limit of 100.0 as 100, as one would write it."""
    return {
        name: int(limit) if isinstance(limit, float) and limit.is_integer() else limit
        for name, limit in context.items()
    }


def _quoted(choices: str) -> str:
    """Return choices in the quotes that a file needs."""
    return choices.replace("'", '"')


def _keys_at(model: type[BaseModel], location: list[Any]) -> list[str]:
    """The keys allowed at a place in the model."""
    return sorted(_model_at(model, location).model_fields)


def _model_at(model: type[BaseModel], location: list[Any]) -> type[BaseModel]:
    """The model of the table at a place in a model."""
    here = model
    for part in location:
        field = here.model_fields.get(str(part))
        # Names of table entries and places in lists are no fields: the model stays.
        if field is not None:
            here = _model_in(field.annotation) or here
    return here


def _model_in(annotation: Any) -> type[BaseModel] | None:  # noqa: ANN401 - a type form
    """The model that an annotation such as ``tuple[Condition, ...]`` or ``Part | None`` holds."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_model_in(part) for part in get_args(annotation))
    return next((model for model in found if model), None)


def missing_paths(found: Checked[Any]) -> list[str]:
    """Return a problem for each entry under [assumptions] that is about no setting of the file."""
    assumptions = found.raw.get("assumptions")
    yet_to_come = tuple(f"{path}." for path in found.absent)
    words = "names no setting of this file; write the key path of one"
    return [
        f'assumptions: "{path}" {words}'
        for path in (assumptions if isinstance(assumptions, dict) else ())
        if not _has_path(found.raw, path) and not f"{path}.".startswith(yet_to_come)
    ]


def _has_path(raw: object, path: str) -> bool:
    """Whether a key path such as ``conditions.assisted.view`` leads somewhere."""
    node = raw
    for step in path.split("."):
        if isinstance(node, list):
            node = next(
                (item for item in node if isinstance(item, dict) and item.get("name") == step), None
            )
        elif isinstance(node, dict):
            node = node.get(step)
        if node is None:
            return False
    return True
