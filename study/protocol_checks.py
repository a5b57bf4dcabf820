"""A protocol's names and settings, held against the members that they are of.

All is looked at that can be: a table that is wrong by itself hides nothing in the others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from types import ModuleType

from pydantic import BaseModel

from study.errors import ProtocolError, StudyError
from study.events.task_description import TaskDescription
from study.families import load_member
from study.messages import locales
from study.protocol import Examined, Protocol
from study.rules import WRONG, broken, right_settings
from study.seat_settings import DIRECTIONS, KEY_NAMES
from study.spelling import closest
from study.validation import checked

_ALIASES = {"enter": "return", "esc": "escape", "spacebar": "space", "minus": "-", "equals": "="}


def check_members(examined: Examined, problems: list[str]) -> TaskDescription | None:
    """Check all that a protocol names.

    Args:
        examined: what its file says.
        problems: to be added to.

    Returns:
        The task's description; None if the task is wrong.
    """
    seen, raw = examined.seen, examined.raw
    problems += broken([_language_there, _keys_there], seen)
    task = check_member("study.tasks", "task", "task", raw.get("task"), problems)
    learner = check_member("study.policies", "policy", "policy", raw.get("policy"), problems)
    if learner is not None:
        problems += broken([_learns], seen, learner.module)
    given = raw.get("scorers")
    for name, scorer in given.items() if isinstance(given, dict) else ():
        member = check_member("study.scorers", "scorer", f"scorers.{name}", scorer, problems)
        if member is not None:
            problems += broken([_gate_of_something], seen, name, member.module)
    return None if task is None else _check_task(examined, task, problems)


@dataclasses.dataclass(frozen=True, slots=True)
class Member:
    """A member that is named right.

    Attributes:
        module: the member's.
        parameters: as far as they are right.
        right: whether all of them are.
    """

    module: ModuleType
    parameters: BaseModel
    right: bool


def check_member(
    package: str, family: str, path: str, given: object, problems: list[str]
) -> Member | None:
    """Check a member's name and parameters.

    Args:
        package: with the family's files.
        family: as it is called in messages.
        path: of the table that names the member.
        given: that table, as plain values.
        problems: to be added to.

    Returns:
        The member; None if it is not named right.
    """
    name = given.get("name") if isinstance(given, dict) else None
    parameters = given.get("parameters", {}) if isinstance(given, dict) else None
    if not isinstance(name, str):
        return None
    try:
        module = load_member(package, family, name)
    except StudyError as error:
        problems.append(f"{path}.name: {error.sentence}")
        return None
    if not isinstance(parameters, dict):
        return None
    if not hasattr(module, "Parameters"):
        problems.append(
            f'{path}.name: the {family} "{name}" has no class Parameters; '
            "docs/how-to says what each family's files hold"
        )
        return None
    try:
        found = checked(module.Parameters, parameters, f"{path}.parameters")
    except StudyError as error:
        problems.append(f"{path}.parameters: {error.sentence}")
        return None
    problems += found.problems
    return Member(module, found.seen, right=found.made is not None)


def _check_task(examined: Examined, task: Member, problems: list[str]) -> TaskDescription | None:
    problems += broken([_same_rate], examined.seen, task.parameters)
    if not task.right:
        return None
    try:
        description: TaskDescription = task.module.describe(
            examined.raw["task"].get("parameters", {})
        )
    except ProtocolError as error:
        problems += error.problems
        return None
    except StudyError as error:
        problems.append(f"task: {error.sentence}")
        return None
    problems += broken([_keys_free, _pictures_taken], examined.seen, description)
    return description


def _language_there(protocol: Protocol) -> Iterator[str]:
    language = protocol.study.language
    if language not in locales():
        yield f'study.language: no texts in "{language}"; there are {", ".join(locales())}'


def _learns(protocol: Protocol, module: ModuleType) -> Iterator[str]:
    if not hasattr(module, "fit"):
        yield (
            f'policy.name: "{protocol.policy.name}" learns nothing from demonstrations; '
            'use one that does, such as "nearest_neighbor"'
        )


def _pictures_taken(protocol: Protocol, description: TaskDescription) -> Iterator[str]:
    pictures = protocol.recording.pictures
    if pictures != "none" and not description.scene.camera:
        yield (
            f'recording.pictures: "{pictures}" given, but the task '
            f'"{protocol.task.name}" takes no pictures as it is set here; leave it out, '
            'or set "none"'
        )


def _keys_there(protocol: Protocol) -> Iterator[str]:
    """Refuse keys that the window never tells of: what is bound to them could not be done."""
    bound = right_settings(protocol.keys)
    robots: tuple[str, ...] = bound.pop("robots", ())
    named = [(f"keys.{name}", key) for name, key in bound.items()]
    named += [
        (f"keys.robots.{number}", key)
        for number, key in enumerate(robots, start=1)
        if key is not WRONG
    ]
    words = [name for name in KEY_NAMES if len(name) > 1]
    allowed = f"{', '.join(words)}, a to z, 0 to 9, - and ="
    for path, key in named:
        if key not in KEY_NAMES:
            near = _ALIASES.get(key.lower()) or closest(key.lower(), KEY_NAMES)
            hint = f'; did you mean "{near}"?' if near else ""
            if key.lower() == "f12":
                hint = "; F12 stops real robots, whatever a protocol says"
            yield f'{path}: "{key[:40]}" given; allowed: {allowed}{hint}'


def _keys_free(protocol: Protocol, description: TaskDescription) -> Iterator[str]:
    """Refuse keys that the task names itself where they mean something else already."""
    bound = right_settings(protocol.keys)
    robots: tuple[str, ...] = bound.pop("robots", ())
    taken = {key: f"keys.{name}" for name, key in bound.items()}
    taken |= dict.fromkeys(robots, "keys.robots")
    for key in description.key_actions:
        if key not in DIRECTIONS and key in taken:
            yield f'task.parameters.keys: "{key}" is {taken[key]} already; each key does one thing'


def _same_rate(protocol: Protocol, parameters: BaseModel) -> Iterator[str]:
    """Refuse a task whose own time, given in seconds, is not that of the study."""
    rate = right_settings(parameters).get("timesteps_per_second")
    wanted = protocol.timing.timesteps_per_second
    if rate is not None and rate != wanted:
        yield (
            f"task.parameters.timesteps_per_second: {rate:g} given or usual; must be that of "
            f"timing.timesteps_per_second, {wanted:g}"
        )


def _gate_of_something(protocol: Protocol, name: str, module: ModuleType) -> Iterator[str]:
    """Refuse a gate at a scorer that is not fitted to choices: it would never pass."""
    scorer = protocol.scorers[name]
    if scorer.gate is not None and getattr(module, "IS_CONTROL", False):
        yield (
            f'scorers.{name}.gate: given for "{scorer.name}", which learns nothing from '
            "choices, so that nothing can be measured; put the gate at a scorer that does, "
            'such as "luce"'
        )
