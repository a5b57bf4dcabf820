"""The plan lock: what was decided before the first record, beside the protocol and in recordings.

`study lock` writes it; `study run` and `study simulate` put it into every recording after that;
the report holds it against what it finds.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from study.errors import StudyError

ATTACHMENT = "plan.lock.json"
"""Name of the lock inside a recording."""
SUFFIX = ".lock.json"
"""What the lock's file has in place of the protocol's ``.toml``."""
FORMAT = 1
MAX_BYTES = 2_000_000


@dataclasses.dataclass(frozen=True, slots=True)
class PlanLock:
    """What a lock holds.

    Attributes:
        locked_utc: when it was made, ISO 8601, UTC.
        protocol_sha256: of the protocol file's bytes, hexadecimal.
        protocol_toml: the protocol file, so that a later difference can be shown.
        questionnaires_sha256: of the questionnaires as recordings hold them.
        exclusions: the declared rules, of participants and of trials, as canonical JSON.
        planned: names of the planned analyses.
        analysis_files: SHA-256 of each file of the analysis, by its path.
        environment: versions of what computes, by name.
    """

    locked_utc: str
    protocol_sha256: str
    protocol_toml: str
    questionnaires_sha256: str
    exclusions: str
    planned: tuple[str, ...]
    analysis_files: Mapping[str, str]
    environment: Mapping[str, str]

    def to_json(self) -> str:
        """Return the lock as its file holds it."""
        content = {"format": FORMAT, **dataclasses.asdict(self)}
        return json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n"

    def same_plan(self, other: PlanLock) -> bool:
        """Whether another lock fixes the same things, whenever it was made."""
        return dataclasses.replace(self, locked_utc=other.locked_utc) == other


def parse_lock(data: bytes, source: str) -> PlanLock:
    """Read a lock.

    Args:
        data: the file's bytes.
        source: its name, for messages.

    Raises:
        StudyError: it is no lock, or one of a newer version.
    """
    hint = "Make it anew with `study lock PROTOCOL --again`."
    try:
        content: Any = json.loads(data.decode("utf-8"))
        if content["format"] != FORMAT:
            raise StudyError(f"{source}: a lock of format {content['format']}, not {FORMAT}", hint)
        if datetime.fromisoformat(content["locked_utc"]).tzinfo is None:
            raise ValueError("a time without a zone")
        texts = ("locked_utc", "protocol_sha256", "protocol_toml", "questionnaires_sha256")
        files, environment = content["analysis_files"], content["environment"]
        return PlanLock(
            **{name: str(content[name]) for name in texts},
            exclusions=str(content["exclusions"]),
            planned=tuple(str(name) for name in content["planned"]),
            analysis_files={str(name): str(value) for name, value in files.items()},
            environment={str(name): str(value) for name, value in environment.items()},
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise StudyError(f"{source}: is no plan lock ({type(error).__name__})", hint) from error


def lock_path(protocol: Path) -> Path:
    """Return where a protocol's lock lies: beside it."""
    return protocol.with_name(protocol.stem + SUFFIX)


def read_lock(protocol: Path) -> tuple[bytes, PlanLock] | None:
    """Return the lock beside a protocol, as bytes and parsed; None if there is none.

    Raises:
        StudyError: it cannot be read or is none.
    """
    path = lock_path(protocol)
    try:
        if not path.is_file():
            return None
        if path.stat().st_size > MAX_BYTES:
            raise StudyError(f"{path}: larger than any plan lock", "Remove it, or lock anew.")
        data = path.read_bytes()
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {error.strerror}") from error
    return data, parse_lock(data, str(path))


def canonical_rules(protocol: Mapping[str, Any]) -> str:
    """Return a protocol's rules of exclusion as text that does not depend on the order of keys."""
    rules = {key: protocol.get(key) or [] for key in ("exclusions", "trial_exclusions")}
    return json.dumps(rules, sort_keys=True, ensure_ascii=False, default=str)
