"""Writing files: whole or not at all, and for their owner alone."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Sequence
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


def claim_folder(folder: Path, mark: str, what: str, replaced: Sequence[str]) -> None:
    """Make a folder for outputs of one kind, or empty it of an earlier output of that kind.

    What an earlier output has and this one has not would else be taken for a part of this one.

    Args:
        folder: where the output goes.
        mark: name of a file that every output of that kind has.
        what: the output, as in "an earlier {what}".
        replaced: patterns of the files and folders that such an output has, as of `Path.glob`.

    Raises:
        StudyError: it cannot be made or emptied, or holds other files and no earlier output.
    """
    make_folder(folder)
    try:
        names = sorted(path.name for path in folder.iterdir())
        if names and mark not in names:
            raise StudyError(
                f"the folder {folder} holds other files ({names[0]}"
                f"{', ...' if len(names) > 1 else ''}) and no earlier {what}",
                "Choose a new or empty folder with -o.",
            )
        for pattern in replaced:
            for path in folder.glob(pattern):
                if path.is_dir() and not path.is_symlink():
                    shutil.rmtree(path)
                else:
                    path.unlink()
    except OSError as error:
        raise StudyError(
            f"the folder {folder} cannot be emptied of an earlier {what}: {error.strerror}",
            "Choose another with -o.",
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
