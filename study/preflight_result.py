"""What a preflight found: one line a check, and the file that a session's start looks at."""

from __future__ import annotations

import dataclasses
import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from study.errors import StudyError
from study.whole_file import part_of, replace_text

State = Literal["green", "amber", "red"]
FILE = "preflight.json"
LARGEST_FILE = 100_000
FRESH_HOURS = 24.0


class Check(BaseModel):
    """One thing that was looked at.

    Attributes:
        name: what.
        state: green: as it should be; amber: to know; red: a session would suffer.
        found: what was measured, in words.
        wanted: what it should be.
        advice: what to do; empty if it is green.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    state: State
    found: str
    wanted: str
    advice: str = ""


class Preflight(BaseModel):
    """All checks of one preflight.

    Attributes:
        utc: when, ISO 8601.
        host: computer.
        protocol: path of the file.
        protocol_sha256: of its bytes.
        participant: whose sequence was rehearsed; empty if nobody's in particular.
        seconds: how long it took.
        checks: in the order in which they were made.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    utc: str
    host: str
    protocol: str
    protocol_sha256: str
    participant: str = ""
    seconds: float
    checks: tuple[Check, ...]

    @property
    def state(self) -> State:
        """The worst state of any check."""
        found = {check.state for check in self.checks}
        return "red" if "red" in found else "amber" if "amber" in found else "green"

    @property
    def sentence(self) -> str:
        """All of it in one line, as recordings hold it."""
        worse = "; ".join(
            f"{check.name} {check.state}: {check.found}"
            for check in self.checks
            if check.state != "green"
        )
        green = sum(check.state == "green" for check in self.checks)
        counted = f"preflight {self.utc}: {green} of {len(self.checks)} green"
        return f"{counted}; {worse}" if worse else counted

    def age_hours(self) -> float:
        """Return how long ago it was made, h."""
        return (datetime.now(UTC) - datetime.fromisoformat(self.utc)).total_seconds() / 3600


def read_preflight(folder: Path) -> Preflight | None:
    """Return the last preflight made for recordings in a folder; None if there is none.

    Raises:
        StudyError: the file is none, or cannot be read.
    """
    path = folder / FILE
    try:
        with path.open("rb") as file:
            text = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror}") from error
    try:
        if len(text) > LARGEST_FILE:
            raise ValueError("too large")
        found = Preflight.model_validate_json(text)
        found.age_hours()
    except (ValidationError, ValueError, TypeError) as error:
        raise StudyError(
            f"{path} is no preflight's result", "Run `study preflight` again; it replaces the file."
        ) from error
    return found


def keep_preflight(folder: Path, found: Preflight) -> None:
    """Keep a preflight's result for the sessions that are recorded in a folder.

    Raises:
        OSError: it cannot be written.
    """
    replace_text(folder / FILE, found.model_dump_json(indent=1) + "\n", private=True)


def forget_rehearsed(folder: Path, pseudonym: str) -> None:
    """Drop a participant's pseudonym from the preflight kept in a folder; the rest still counts.

    Raises:
        StudyError: the file can be neither changed nor erased.
    """
    path = folder / FILE
    try:
        # One that was killed while it wrote may have left the name there.
        part_of(path).unlink(missing_ok=True)
        try:
            found = read_preflight(folder)
        except StudyError:
            # Whom it names cannot be told, and it is of no use to anybody.
            path.unlink()
            return
        if found is not None and found.participant.casefold() == pseudonym.casefold():
            keep_preflight(folder, found.model_copy(update={"participant": ""}))
    except OSError as error:
        raise StudyError(
            f"{path} may name {pseudonym}, and cannot be changed: {error.strerror}",
            "Mend that, or remove the file by hand.",
        ) from error


def as_json(found: Preflight) -> str:
    """Return a preflight as a program reads it, its overall state included."""
    return json.dumps({"state": found.state, **found.model_dump(mode="json")}, indent=1)


@dataclasses.dataclass(frozen=True, slots=True)
class Limits:
    """From when on a number is amber, and from when on red.

    Attributes:
        amber, red: at least this much.
    """

    amber: float
    red: float

    def state(self, value: float) -> State:
        """Return the state of a value that should be small."""
        return "red" if value >= self.red else "amber" if value >= self.amber else "green"
