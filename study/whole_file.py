"""Writes a small text file in one step."""

from __future__ import annotations

import os
from pathlib import Path


def replace_text(path: Path, text: str, *, private: bool = False) -> None:
    """Write a file, durably, so that nobody ever sees half of it; one of that name is replaced.

    Args:
        path: of the file.
        text: all of it.
        private: whether it is for its owner alone, from the first moment.

    Raises:
        OSError: it cannot be written.
    """
    part = part_of(path)
    part.unlink(missing_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
    descriptor = os.open(part, flags, 0o600 if private else 0o666)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(part, path)  # noqa: PTH105 - Path.replace reads as a change of text
    except BaseException:
        # As where the disk is full: nobody would find a hidden file of half a text.
        part.unlink(missing_ok=True)
        raise


def part_of(path: Path) -> Path:
    """Return where a file is while it is written; one that was killed may leave it there."""
    return path.with_name(f".{path.name}.part")
