"""Emptying a folder of simulated recordings, and of nothing that a person made."""

from __future__ import annotations

from pathlib import Path

from study.errors import StudyError
from study.recording.reader import read_recording


def clear_simulated(folder: Path, hint: str) -> None:
    """Remove the simulated recordings of an earlier run.

    Args:
        folder: that is emptied; it need not exist.
        hint: what to do where it holds something else, without a full stop.

    Raises:
        StudyError: it holds something else; nothing is removed then.
    """
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    for path in found:
        if not is_simulated(path):
            raise StudyError(
                f"{path} is no recording of a simulated participant",
                f"{hint}; the one given is emptied.",
            )
    for path in found:
        path.unlink()


def is_simulated(path: Path) -> bool:
    """Whether a file is a recording of a simulated participant, and says so itself."""
    try:
        return read_recording(path).metadata.get("operator_kind") == "simulated"
    except (StudyError, OSError):
        return False
