"""What options that name places for results are checked for, in both programs."""

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
    file = _in_the_way(given)
    if file is not None:
        which = "names a file" if file == given else f"lies in {file}, which is a file"
        raise StudyError(
            f"-o {given} {which}; a folder is wanted",
            "Give a folder; one that is not there yet is made.",
        )
    return given


def new_file_wanted(option: str, given: Path) -> None:
    """Check where an option's new file is to lie: as with ``-o``, a folder is made for it.

    Raises:
        StudyError: what it would lie in is a file.
    """
    file = _in_the_way(given.parent)
    if file is not None:
        raise StudyError(
            f"{option} {given} lies in {file}, which is a file; a folder is wanted",
            "Give a file in a folder; one that is not there yet is made.",
        )


def _in_the_way(folder: Path) -> Path | None:
    """Return the file that is, or is above, what is to be a folder; None if there is none."""
    for place in (folder, *folder.parents):
        if place.is_dir():
            return None
        if place.exists():
            return place
    return None
