"""Protocols and questionnaires from files, checked in full: the members that they name too."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from pydantic import ValidationError

from study.errors import ProtocolError, StudyError, UnknownNameError
from study.events.task_description import TaskDescription
from study.families import load_member
from study.messages import locales
from study.protocol import Protocol, parse_protocol
from study.questionnaire import Questionnaire, parse_questionnaire
from study.seat_settings import DIRECTIONS
from study.validation import validation_problems

MAX_BYTES = 1_000_000


@dataclasses.dataclass(frozen=True, slots=True)
class LoadedProtocol:
    """A protocol with all that it refers to.

    Attributes:
        path: where it was found.
        text: the file, in full.
        sha256: of the file's bytes.
        protocol: the validated study.
        questionnaires: by name.
        description: of its task.
    """

    path: Path
    text: str
    sha256: str
    protocol: Protocol
    questionnaires: dict[str, Questionnaire]
    description: TaskDescription

    def questionnaires_json(self) -> str:
        """Return the questionnaires as a recording holds them."""
        asked = {name: item.model_dump(mode="json") for name, item in self.questionnaires.items()}
        return json.dumps(asked, sort_keys=True)


def shipped_protocols() -> Path:
    """Return the folder of the protocols that come with the program."""
    here = Path(__file__).parent
    installed = here / "shipped_protocols"
    return installed if installed.is_dir() else here.parent / "protocols"


def find_protocol(given: str) -> Path:
    """Return the file that a user means: a path, or the name of a shipped protocol.

    Raises:
        StudyError: neither exists.
    """
    path = Path(given)
    if path.is_file():
        return path
    shipped = shipped_protocols()
    name = path.name if path.suffix == ".toml" else f"{path.name}.toml"
    if (path.parent == Path() or path.parent.name == "protocols") and (shipped / name).is_file():
        return shipped / name
    known = ", ".join(sorted(file.stem for file in shipped.glob("*.toml")))
    raise StudyError(
        f"no protocol file {given}", f"Give the path of a TOML file, or one of: {known}."
    )


def load_protocol(given: str) -> LoadedProtocol:
    """Read and check a protocol file and all that it names.

    Raises:
        StudyError: there is no such file.
        ProtocolError: one message a problem.
    """
    path = find_protocol(given)
    text = read_text(path)
    protocol = parse_protocol(text, str(path))
    problems: list[str] = []
    if protocol.study.language not in locales():
        problems.append(
            f'study.language: no texts in "{protocol.study.language}"; '
            f"there are {', '.join(locales())}"
        )
    description = _check_members(protocol, problems)
    questionnaires: dict[str, Questionnaire] = {}
    for index, use in enumerate(protocol.questionnaires, start=1):
        try:
            questionnaires[use.name] = load_questionnaire(use.name, path.parent)
        except UnknownNameError as error:
            problems.append(f"questionnaires.{index}.name: {error.message}; {error.hint}")
    if description is not None:
        _check_policy_learns(protocol, problems)
        _check_gates(protocol, problems)
        _check_pictures(protocol, description, problems)
    if problems or description is None:
        raise ProtocolError(str(path), problems)
    return LoadedProtocol(
        path=path,
        text=text,
        sha256=hashlib.sha256(text.encode()).hexdigest(),
        protocol=protocol,
        questionnaires=questionnaires,
        description=description,
    )


def load_questionnaire(name: str, folder: Path) -> Questionnaire:
    """Read a questionnaire from beside the protocol, or from the shipped ones.

    Raises:
        UnknownNameError: there is none of that name.
        ProtocolError: the file is wrong.
    """
    places = [folder / "questionnaires", shipped_protocols() / "questionnaires"]
    for place in places:
        path = place / f"{name}.toml"
        if path.is_file():
            questionnaire = parse_questionnaire(read_text(path), str(path))
            if questionnaire.name != name:
                problem = f'name: "{questionnaire.name}" given; must be the file\'s, "{name}"'
                raise ProtocolError(str(path), [problem])
            return questionnaire
    known = sorted({file.stem for place in places for file in place.glob("*.toml")})
    raise UnknownNameError("questionnaire", name, known)


def read_text(path: Path) -> str:
    """Read a small UTF-8 file.

    Raises:
        StudyError: it cannot be read, is too large or is no text.
    """
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise StudyError(f"{path}: {size} bytes; a protocol has at most {MAX_BYTES}")
        # Bytes first: reading as text would change line ends, and with them the hash.
        return path.read_bytes().decode("utf-8")
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise StudyError(f"{path}: not UTF-8 text", "Save the file as UTF-8.") from error


def _check_members(protocol: Protocol, problems: list[str]) -> TaskDescription | None:
    _check_member(
        "study.tasks", "task", "task", protocol.task.name, protocol.task.parameters, problems
    )
    _check_member(
        "study.policies",
        "policy",
        "policy",
        protocol.policy.name,
        protocol.policy.parameters,
        problems,
    )
    for key, scorer in protocol.scorers.items():
        _check_member(
            "study.scorers", "scorer", f"scorers.{key}", scorer.name, scorer.parameters, problems
        )
    if problems:
        return None
    module = load_member("study.tasks", "task", protocol.task.name)
    try:
        description: TaskDescription = module.describe(protocol.task.parameters)
    except StudyError as error:
        problems.append(f"task: {error.message}; {error.hint}")
        return None
    _check_keys(protocol, description, problems)
    _check_rate(protocol, module, problems)
    return description


def _check_keys(protocol: Protocol, description: TaskDescription, problems: list[str]) -> None:
    """Refuse keys that the task names itself where they mean something else already."""
    bound = protocol.keys.model_dump()
    robots: list[str] = bound.pop("robots")
    taken = {key: f"keys.{name}" for name, key in bound.items()}
    taken |= dict.fromkeys(robots, "keys.robots")
    problems += [
        f'task.parameters.keys: "{key}" is {taken[key]} already; each key does one thing'
        for key in description.key_actions
        if key not in DIRECTIONS and key in taken
    ]


def _check_rate(protocol: Protocol, module: ModuleType, problems: list[str]) -> None:
    """Refuse a task whose own time, given in seconds, is not that of the study."""
    settings = module.Parameters.model_validate(protocol.task.parameters)
    rate = getattr(settings, "timesteps_per_second", None)
    if rate is not None and rate != protocol.timing.timesteps_per_second:
        problems.append(
            f"task.parameters.timesteps_per_second: {rate:g} given or usual; must be that of "
            f"timing.timesteps_per_second, {protocol.timing.timesteps_per_second:g}"
        )


def _check_member(
    package: str, family: str, path: str, name: str, given: dict[str, Any], problems: list[str]
) -> None:
    try:
        module = load_member(package, family, name)
    except StudyError as error:
        problems.append(f"{path}.name: {error.message}; {error.hint}")
        return
    try:
        module.Parameters.model_validate(given)
    except ValidationError as error:
        problems += validation_problems(error, module.Parameters, f"{path}.parameters")
    except StudyError as error:
        problems.append(f"{path}.parameters: {error.message}; {error.hint}")


def _check_policy_learns(protocol: Protocol, problems: list[str]) -> None:
    if not hasattr(load_member("study.policies", "policy", protocol.policy.name), "fit"):
        problems.append(
            f'policy.name: "{protocol.policy.name}" learns nothing from demonstrations; '
            'use one that does, such as "nearest_neighbor"'
        )


def _check_gates(protocol: Protocol, problems: list[str]) -> None:
    """Refuse a gate at a scorer that is not fitted to choices: it would never pass."""
    for key, scorer in protocol.scorers.items():
        module = load_member("study.scorers", "scorer", scorer.name)
        if scorer.gate is not None and getattr(module, "IS_CONTROL", False):
            problems.append(
                f'scorers.{key}.gate: given for "{scorer.name}", which learns nothing from '
                "choices, so that nothing can be measured; put the gate at a scorer that does, "
                'such as "luce"'
            )


def _check_pictures(protocol: Protocol, description: TaskDescription, problems: list[str]) -> None:
    """Refuse to record pictures of a task that takes none."""
    if protocol.recording.pictures != "none" and not description.scene.camera:
        problems.append(
            f'recording.pictures: "{protocol.recording.pictures}" given, but the task '
            f'"{protocol.task.name}" takes no pictures as it is set here; leave it out, or set '
            '"none"'
        )


def missing_extra(task: str, parameters: Mapping[str, object]) -> str:
    """Return what a task lacks to run here, and how to get it, in words; empty if nothing."""
    module = load_member("study.tasks", "task", task)
    missing = getattr(module, "missing_extra", None)
    return str(missing(parameters)) if missing is not None else ""
