"""A protocol's names and settings, held against the members that they are of.

All is looked at that can be: a table that is wrong by itself hides nothing in the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import Any

from pydantic import ValidationError

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.families import load_member
from study.messages import locales
from study.protocol import Examined
from study.scorer_settings import ScorerPart
from study.seat_settings import DIRECTIONS, KEY_NAMES, KeyPart
from study.validation import closest, validation_problems

_ALIASES = {"enter": "return", "esc": "escape", "spacebar": "space", "minus": "-", "equals": "="}


def check_members(examined: Examined, problems: list[str]) -> TaskDescription | None:
    """Check all that a protocol names.

    Args:
        examined: what its file says.
        problems: to be added to.

    Returns:
        The task's description; None if the task is wrong.
    """
    parts = examined.parts
    study, keys, policy = parts.get("study"), parts.get("keys"), parts.get("policy")
    if study is not None and study.language not in locales():
        problems.append(
            f'study.language: no texts in "{study.language}"; there are {", ".join(locales())}'
        )
    if keys is not None:
        problems += _unknown_keys(keys)
    task = _member("study.tasks", "task", "task", examined.raw.get("task"), problems)
    learner = _member("study.policies", "policy", "policy", examined.raw.get("policy"), problems)
    if learner is not None and policy is not None and not hasattr(learner, "fit"):
        problems.append(
            f'policy.name: "{policy.name}" learns nothing from demonstrations; '
            'use one that does, such as "nearest_neighbor"'
        )
    given = examined.raw.get("scorers")
    for name, scorer in given.items() if isinstance(given, dict) else ():
        module = _member("study.scorers", "scorer", f"scorers.{name}", scorer, problems)
        if module is not None and "scorers" in parts:
            problems += _gate_of_nothing(name, parts["scorers"][name], module)
    return None if task is None else _check_task(examined, task, problems)


def _member(
    package: str, family: str, path: str, given: object, problems: list[str]
) -> ModuleType | None:
    """Return a member that is named and set right; None if not, or if it is told already."""
    name = given.get("name") if isinstance(given, dict) else None
    parameters = given.get("parameters", {}) if isinstance(given, dict) else None
    if not isinstance(name, str):
        return None
    try:
        module = load_member(package, family, name)
    except StudyError as error:
        problems.append(f"{path}.name: {error.message}; {error.hint}")
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
        module.Parameters.model_validate(parameters)
    except ValidationError as error:
        problems += validation_problems(error, module.Parameters, f"{path}.parameters")
        return None
    except StudyError as error:
        problems.append(f"{path}.parameters: {error.message}; {error.hint}")
        return None
    return module


def _check_task(
    examined: Examined, module: ModuleType, problems: list[str]
) -> TaskDescription | None:
    given: dict[str, Any] = examined.raw["task"].get("parameters", {})
    parts = examined.parts
    try:
        description: TaskDescription = module.describe(given)
    except StudyError as error:
        problems.append(f"task: {error.message}; {error.hint}")
        return None
    if "keys" in parts:
        problems += _keys_taken(parts["keys"], description)
    if "timing" in parts:
        rate = getattr(module.Parameters.model_validate(given), "timesteps_per_second", None)
        problems += _other_rate(rate, parts["timing"].timesteps_per_second)
    pictures = parts["recording"].pictures if "recording" in parts else "none"
    if pictures != "none" and not description.scene.camera:
        problems.append(
            f'recording.pictures: "{pictures}" given, but the task '
            f'"{examined.raw["task"]["name"]}" takes no pictures as it is set here; leave it out, '
            'or set "none"'
        )
    return description


def _unknown_keys(keys: KeyPart) -> Iterator[str]:
    """Refuse keys that the window never tells of: what is bound to them could not be done."""
    bound = keys.model_dump()
    robots: tuple[str, ...] = bound.pop("robots")
    named = [(f"keys.{name}", key) for name, key in bound.items()]
    named += [(f"keys.robots.{number}", key) for number, key in enumerate(robots, start=1)]
    words = [name for name in KEY_NAMES if len(name) > 1]
    allowed = f"{', '.join(words)}, a to z, 0 to 9, - and ="
    for path, key in named:
        if key not in KEY_NAMES:
            near = _ALIASES.get(key.lower()) or closest(key.lower(), KEY_NAMES)
            hint = f'; did you mean "{near}"?' if near else ""
            if key.lower() == "f12":
                hint = "; F12 stops real robots, whatever a protocol says"
            yield f'{path}: "{key[:40]}" given; allowed: {allowed}{hint}'


def _keys_taken(keys: KeyPart, description: TaskDescription) -> Iterator[str]:
    """Refuse keys that the task names itself where they mean something else already."""
    bound = keys.model_dump()
    robots: list[str] = bound.pop("robots")
    taken = {key: f"keys.{name}" for name, key in bound.items()}
    taken |= dict.fromkeys(robots, "keys.robots")
    for key in description.key_actions:
        if key not in DIRECTIONS and key in taken:
            yield f'task.parameters.keys: "{key}" is {taken[key]} already; each key does one thing'


def _other_rate(rate: float | None, wanted: float) -> Iterator[str]:
    """Refuse a task whose own time, given in seconds, is not that of the study."""
    if rate is not None and rate != wanted:
        yield (
            f"task.parameters.timesteps_per_second: {rate:g} given or usual; must be that of "
            f"timing.timesteps_per_second, {wanted:g}"
        )


def _gate_of_nothing(name: str, scorer: ScorerPart, module: ModuleType) -> Iterator[str]:
    """Refuse a gate at a scorer that is not fitted to choices: it would never pass."""
    if scorer.gate is not None and getattr(module, "IS_CONTROL", False):
        yield (
            f'scorers.{name}.gate: given for "{scorer.name}", which learns nothing from '
            "choices, so that nothing can be measured; put the gate at a scorer that does, "
            'such as "luce"'
        )
