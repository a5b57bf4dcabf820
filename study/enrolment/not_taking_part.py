"""Counting who declined or had all erased."""

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
        replace_text(path, json.dumps(counts, indent=2, sort_keys=True) + "\n", private=True)
    except OSError as error:
        raise StudyError(f"{path}: cannot be written: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise StudyError(f"{path} holds no counts", "Move the file away.") from error
