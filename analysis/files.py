"""Writing files: whole or not at all, and for their owner alone."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path

from study.errors import StudyError


def make_folder(folder: Path) -> None:
    """Make a folder for outputs, private to its owner if it is new.

    Raises:
        StudyError: it cannot be made or is a file.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise StudyError(
            f"the folder {folder} cannot be made: {error.strerror}", "Choose another with -o."
        ) from error


def write_text(path: Path, text: str) -> None:
    """Write a file in one step, so that nobody ever sees half of it.

    Raises:
        StudyError: it cannot be written.
    """
    write_pieces(path, [text])


def write_json(path: Path, content: object) -> None:
    """Write a file of JSON for people to read too.

    Raises:
        StudyError: it cannot be written.
    """
    write_text(path, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def write_pieces(path: Path, pieces: Iterable[str]) -> None:
    """Write a file piece by piece; it appears under its name when it is whole.

    Raises:
        StudyError: it cannot be written.
    """
    part = path.with_name(f".{path.name}.part")
    try:
        with os.fdopen(open_private(part), "w", encoding="utf-8", newline="\n") as stream:
            for piece in pieces:
                stream.write(piece)
        os.replace(part, path)  # noqa: PTH105 - Path.replace reads as a change of text
    except OSError as error:
        raise StudyError(f"{path} cannot be written: {error.strerror}") from error


def open_private(path: Path) -> int:
    """Open a file anew for writing, for its owner alone: it tells of participants.

    Raises:
        OSError: it cannot be made.
    """
    path.unlink(missing_ok=True)
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
