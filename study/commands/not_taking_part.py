"""Counting who declined or had all erased, and erasing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

from study.errors import StudyError
from study.whole_file import replace_text

COUNTS = "not_taking_part.json"
"""File beside the recordings that holds, by study, how many declined and how many erased."""


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
