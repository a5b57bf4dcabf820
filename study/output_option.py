"""What every ``-o`` that names a folder is checked for, in both programs."""

from __future__ import annotations

from pathlib import Path

from study.errors import StudyError


def folder_wanted(given: Path | None) -> Path | None:
    """Return the folder that ``-o`` names, whether it is there or not.

    Raises:
        StudyError: it, or what it would lie in, is a file.
    """
    if given is None:
        return None
    for place in (given, *given.parents):
        if place.is_dir():
            break
        if place.exists():
            which = "names a file" if place == given else f"lies in {place}, which is a file"
            raise StudyError(
                f"-o {given} {which}; a folder is wanted",
                "Give a folder; one that is not there yet is made.",
            )
    return given
