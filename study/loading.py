"""Protocols and questionnaires from files, checked in full: the members that they name too."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from study.errors import ProtocolError, StudyError, UnknownNameError
from study.events.task_description import TaskDescription
from study.families import load_member
from study.protocol import Protocol, examine
from study.protocol_checks import check_members
from study.questionnaire import Questionnaire, parse_questionnaire
from study.spelling import closest
from study.toml_text import decoded, parse_toml

MAX_BYTES = 1_000_000


@dataclasses.dataclass(frozen=True, slots=True)
class LoadedProtocol:
    """A protocol with all that it refers to.

    Attributes:
        path: where it was found.
        text: the file, in full, without a byte order mark.
        sha256: of the file's bytes, but for a byte order mark.
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


def find_protocol(given: str, table: str = "") -> Path:
    """Return the file that a user means: a path, or the name of a shipped protocol.

    Args:
        given: by the user.
        table: the shipped ones offered instead have it: "study", or "experiment"; empty for all.

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
    known = sorted(
        file.stem
        for file in shipped.glob("*.toml")
        if not table or table in parse_toml(read_text(file), file.name)
    )
    hint = f"Give the path of a TOML file, or one of: {', '.join(known)}."
    if path.is_dir() and given:
        raise StudyError(f"{given} is a folder; a protocol is a file", hint)
    near = closest(path.stem, known)
    guess = f'Did you mean "{near}"? ' if near else ""
    raise StudyError(f"no protocol file {given}", f"{guess}{hint}")


def load_protocol(given: str) -> LoadedProtocol:
    """Read and check a protocol file and all that it names.

    Raises:
        StudyError: there is no such file.
        ProtocolError: one message a problem.
    """
    path = find_protocol(given, "study")
    text = read_text(path)
    examined = examine(parse_toml(text, str(path)), str(path))
    problems = list(examined.problems)
    description = check_members(examined, problems)
    questionnaires = _questionnaires(examined.raw.get("questionnaires"), path.parent, problems)
    protocol = examined.protocol
    if problems or protocol is None or description is None:
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
            return parse_questionnaire(read_text(path), str(path), name=name)
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
        return decoded(path.read_bytes(), str(path))
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {error.strerror}") from error


def _questionnaires(given: object, folder: Path, problems: list[str]) -> dict[str, Questionnaire]:
    """Load all that are named; what is wrong with the file of one is said with its name."""
    found: dict[str, Questionnaire] = {}
    for index, use in enumerate(given if isinstance(given, list) else (), start=1):
        name = use.get("name") if isinstance(use, dict) else None
        if not isinstance(name, str):
            continue
        try:
            found[name] = load_questionnaire(name, folder)
        except UnknownNameError as error:
            problems.append(f"questionnaires.{index}.name: {error.sentence}")
        except ProtocolError as error:
            problems += [f"{error.source}: {problem}" for problem in error.problems]
        except StudyError as error:
            problems.append(error.sentence)
    return found


def missing_extra(task: str, parameters: Mapping[str, object]) -> str:
    """Return what a task lacks to run here, and how to get it, in words; empty if nothing."""
    module = load_member("study.tasks", "task", task)
    missing = getattr(module, "missing_extra", None)
    return str(missing(parameters)) if missing is not None else ""
