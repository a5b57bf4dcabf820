"""The results of an experiment: a folder with one file a trial, whole or not there at all.

    RESULTS/experiment.json     what was run: the protocol's text, seed set, versions
    RESULTS/trial_00007.json    one trial: rows of each table, and the SHA-256 of them

Every file is JSON in UTF-8 with the SHA-256 of its content, written beside and then renamed.
Reading trusts nothing: size, shape, hash and types are checked. What took how long stands
apart from the content, since no two runs agree on it.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from study.errors import StudyError
from study.trial_tables import COLUMNS
from study.whole_file import replace_text

FORMAT = 1
MAX_BYTES = 16_000_000
MAX_TRIALS = 100_000
HEAD = "experiment.json"
SEED_SETS = ("development", "held_out")

Row = dict[str, Any]
Tables = dict[str, list[Row]]

_NAME = re.compile(r"trial_(\d{5})\.json")

_TYPES: Mapping[str, tuple[type, ...]] = {
    "whole": (int,),
    "text": (str,),
    "number": (int, float, type(None)),
}


@dataclasses.dataclass(frozen=True, slots=True)
class Head:
    """What an experiment's folder says of itself.

    Attributes:
        protocol: the text of its file.
        sha256: of that text.
        seeds: "development" or "held_out".
        versions: of program and packages, by name.
    """

    protocol: str
    sha256: str
    seeds: str
    versions: Mapping[str, str]


@dataclasses.dataclass(frozen=True, slots=True)
class TrialFile:
    """One trial's results.

    Attributes:
        trial: its number, from 0.
        tables: rows by table.
        sha256: of the content: equal for equal results.
        seconds: how long it took, not part of the content.
        versions: with which it was computed, not part of the content.
    """

    trial: int
    tables: Tables
    sha256: str
    seconds: float
    versions: Mapping[str, str]


@dataclasses.dataclass(frozen=True, slots=True)
class Results:
    """What was read of an experiment's folder.

    Attributes:
        folder: where.
        head: what was run.
        trials: those that are whole, in order.
        damaged: (file's name, what is wrong) of the others.
    """

    folder: Path
    head: Head
    trials: tuple[TrialFile, ...]
    damaged: tuple[tuple[str, str], ...]


def is_results(path: Path) -> bool:
    """Say whether a path is the folder of an experiment's results."""
    return (path / HEAD).is_file()


def write_head(folder: Path, head: Head) -> None:
    """Write what is run, or check that the folder holds results of just that.

    Raises:
        StudyError: it holds those of another protocol or other seeds, or cannot be written.
    """
    if is_results(folder):
        found = read_head(folder)
        for what, here, given in (
            ("another protocol", found.sha256, head.sha256),
            ("other seeds", found.seeds, head.seeds),
        ):
            if here != given:
                raise StudyError(
                    f"{folder} holds results of {what} ({here[:12]}, not {given[:12]})",
                    "Give another folder with --output.",
                )
        return
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise StudyError(f"the folder {folder} cannot be made: {error.strerror}") from error
    if others := [path.name for path in folder.iterdir() if not path.name.endswith(".part")]:
        raise StudyError(
            f"{folder} holds other files ({others[0]})", "Give another folder with --output."
        )
    content = {
        "format": FORMAT,
        "kind": "experiment",
        "protocol": head.protocol,
        "protocol_sha256": head.sha256,
        "seeds": head.seeds,
        "versions": dict(head.versions),
    }
    _write(folder / HEAD, content)


def read_head(folder: Path) -> Head:
    """Read what an experiment's folder says of itself.

    Raises:
        StudyError: it is none, or damaged.
    """
    path = folder / HEAD
    content = _read(path)
    text, seeds = content.get("protocol"), content.get("seeds")
    if content.get("kind") != "experiment" or not isinstance(text, str) or seeds not in SEED_SETS:
        raise StudyError(f"{path}: no experiment's results")
    sha256 = hashlib.sha256(text.encode()).hexdigest()
    if sha256 != content.get("protocol_sha256"):
        raise StudyError(f"{path}: damaged: the protocol's hash differs")
    return Head(text, sha256, str(seeds), _versions(content))


def write_trial(
    folder: Path,
    trial: int,
    tables: Tables,
    *,
    protocol_sha256: str,
    seconds: float,
    versions: Mapping[str, str],
) -> Path:
    """Write one trial's file, replacing one that is there.

    Raises:
        StudyError: a row is not as `COLUMNS` says, or the file cannot be written.
    """
    if problem := _problem(trial, tables):
        raise StudyError(f"trial {trial} cannot be written: {problem}")
    content = {"trial": trial, "protocol_sha256": protocol_sha256, "tables": tables}
    path = folder / file_name(trial)
    _write(
        path,
        {
            "format": FORMAT,
            "kind": "trial",
            "sha256": _digest(content),
            "content": content,
            "seconds": round(seconds, 3),
            "versions": dict(versions),
        },
    )
    return path


def read_trial(path: Path, protocol_sha256: str) -> TrialFile:
    """Read one trial's file.

    Raises:
        StudyError: it is damaged, or of another protocol.
    """
    record = _read(path)
    content, sha256 = record.get("content"), record.get("sha256")
    if record.get("kind") != "trial" or not isinstance(content, dict):
        raise StudyError(f"{path.name}: no trial's results")
    if not isinstance(sha256, str) or _digest(content) != sha256:
        raise StudyError(f"{path.name}: damaged: its hash differs")
    if content.get("protocol_sha256") != protocol_sha256:
        raise StudyError(f"{path.name}: results of another protocol")
    trial, tables = content.get("trial"), content.get("tables")
    if not isinstance(trial, int) or file_name(trial) != path.name:
        raise StudyError(f"{path.name}: holds another trial")
    if not isinstance(tables, dict):
        raise StudyError(f"{path.name}: it has no tables")
    if problem := _problem(trial, tables):
        raise StudyError(f"{path.name}: {problem}")
    seconds = record.get("seconds")
    return TrialFile(
        trial,
        tables,
        sha256,
        float(seconds) if isinstance(seconds, int | float) else 0.0,
        _versions(record),
    )


def read_results(folder: Path) -> Results:
    """Read all that an experiment's folder holds; damaged files are named, not used.

    Raises:
        StudyError: it is no experiment's folder.
    """
    head = read_head(folder)
    trials: list[TrialFile] = []
    damaged: list[tuple[str, str]] = []
    for path in trial_paths(folder):
        try:
            trials.append(read_trial(path, head.sha256))
        except StudyError as error:
            damaged.append((path.name, error.message))
    return Results(folder, head, tuple(trials), tuple(damaged))


def trial_paths(folder: Path) -> list[Path]:
    """Return the trials' files, in order."""
    return sorted(path for path in folder.iterdir() if _NAME.fullmatch(path.name))[:MAX_TRIALS]


def file_name(trial: int) -> str:
    """Return the name of a trial's file."""
    return f"trial_{trial:05d}.json"


def results_sha256(trials: Sequence[TrialFile]) -> str:
    """Return one hash for all trials' contents: equal for equal results, in any order."""
    lines = "".join(f"{each.trial} {each.sha256}\n" for each in sorted(trials, key=_number))
    return hashlib.sha256(lines.encode()).hexdigest()


def _number(each: TrialFile) -> int:
    return each.trial


def _versions(record: Mapping[str, Any]) -> dict[str, str]:
    versions = record.get("versions")
    if not isinstance(versions, dict):
        return {}
    return {str(name)[:100]: str(value)[:100] for name, value in versions.items()}


def _problem(trial: int, tables: Mapping[str, Any]) -> str:
    """Say what is wrong with a trial's tables; nothing if they are as `COLUMNS` says."""
    if set(tables) != set(COLUMNS):
        return f"its tables are {', '.join(sorted(map(str, tables)))}"
    for name, rows in tables.items():
        if not isinstance(rows, list):
            return f"table {name} is no list"
        for row in rows:
            if not isinstance(row, dict) or set(row) != set(COLUMNS[name]):
                return f"a row of {name} has other columns"
            if row["trial"] != trial:
                return f"a row of {name} is of another trial"
            for column, (kind, _) in COLUMNS[name].items():
                value = row[column]
                if isinstance(value, bool) or not isinstance(value, _TYPES[kind]):
                    return f"{name}.{column} is no {kind}: {str(value)[:40]}"
    return ""


def _digest(content: object) -> str:
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _write(path: Path, record: object) -> None:
    text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    try:
        replace_text(path, text, private=True)
    except OSError as error:
        raise StudyError(f"{path} cannot be written: {error.strerror}") from error


def _read(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise StudyError(f"{path}: larger than {MAX_BYTES} bytes")
        record = json.loads(data.decode("utf-8"), parse_constant=_refuse)
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise StudyError(f"{path}: no JSON") from error
    if not isinstance(record, dict) or record.get("format") != FORMAT:
        raise StudyError(f"{path}: no results of format {FORMAT}")
    return record


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no JSON")
