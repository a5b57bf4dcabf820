"""Asking for consent before anything is recorded, and counting who declined or withdrew."""

from __future__ import annotations

import dataclasses
import json
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from study.commands.whole_file import replace_text
from study.errors import StudyError
from study.loading import LoadedProtocol
from study.messages import messages_for
from study.session.consent import Consent, consent_sha256
from study.shell.raw_inputs import RawClose, RawKey, RawPointer
from study.shell.window import Window

COUNTS = "not_taking_part.json"
"""File beside the recordings that holds, by study, how many declined and how many erased."""


@dataclasses.dataclass(frozen=True, slots=True)
class Given:
    """What was agreed to, and when.

    Attributes:
        sha256: of the text, hexadecimal.
        utc: wall time, ISO 8601.
    """

    sha256: str = ""
    utc: str = ""


def ask_for_consent(loaded: LoadedProtocol, window: Window, folder: Path) -> Given | None:
    """Show the text until it is agreed to or declined; None if declined or closed.

    Args:
        loaded: the protocol, which has a consent text.
        window: where it is shown.
        folder: where declining is counted.
    """
    part = loaded.protocol.consent
    assert part is not None  # noqa: S101 - asked only where there is a text
    consent = Consent(loaded.protocol, messages_for(loaded.protocol.study.language))
    began = time.perf_counter_ns()
    window.show(consent.screen())
    while True:
        for raw in window.poll():
            decision = ""
            if isinstance(raw, RawClose):
                return None
            if isinstance(raw, RawKey) and raw.down:
                decision = consent.key(raw.key)
            elif isinstance(raw, RawPointer):
                decision = consent.point(raw.target)
            if decision == "agreed":
                utc = datetime.now(UTC).isoformat(timespec="milliseconds")
                return Given(consent_sha256(part), utc)
            if decision == "declined":
                count(folder, loaded.protocol.study.name, "declined")
                return None
            window.show(consent.screen())
        window.draw(time.perf_counter_ns() - began)
        window.wait(1 / window.refresh_hz)


def count(folder: Path, study: str, what: Literal["declined", "erased"]) -> None:
    """Add one to a count. Nothing else about the person is kept.

    Raises:
        StudyError: the file cannot be written, or holds something else.
    """
    path = folder / COUNTS
    try:
        folder.mkdir(parents=True, exist_ok=True)
        counts = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
        of_study = counts.setdefault(study, {"declined": 0, "erased": 0})
        of_study[what] += 1
        replace_text(path, json.dumps(counts, indent=2, sort_keys=True) + "\n")
    except OSError as error:
        raise StudyError(f"{path}: cannot be written: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise StudyError(f"{path} holds no counts", "Move the file away.") from error


def erase(paths: list[Path], folder: Path, study: str) -> None:
    """Remove a session's files and count it.

    Args:
        paths: all parts, finished.
        folder: where the count is kept.
        study: its name.

    Raises:
        StudyError: a file cannot be removed; the message names it.
    """
    for path in paths:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise StudyError(
                f"{path} could not be erased: {error.strerror}",
                "The participant asked for it: remove the file by hand.",
            ) from error
    count(folder, study, "erased")
