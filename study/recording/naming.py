"""Where a recording goes."""

from __future__ import annotations

from pathlib import Path

from study.errors import StudyError


def recording_path(folder: Path, name: str) -> Path:
    """Return the final path of a recording; make its folder, for its owner only, if need be.

    Raises:
        StudyError: the name cannot be a file's, or the folder cannot be made.
    """
    if not name or name != Path(name).name or name.startswith("."):
        raise StudyError(
            f'"{name}" cannot be the name of a recording',
            "Give a file name without folders that does not begin with a dot.",
        )
    folder = folder.absolute()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise StudyError(
            f"the folder {folder} cannot be made: {error.strerror}",
            "Choose another folder for recordings, or make that one writable.",
        ) from error
    return folder / f"{name}.mcap"
