"""Which recordings a register speaks for: those in its folder and in all folders under that.

It ends where a folder has a register of its own. Analysis reads folders to the bottom; so does
whatever asks here.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Collection
from pathlib import Path

FILE_NAME = "participants.sqlite"
"""Name of a register."""


@dataclasses.dataclass(frozen=True, slots=True)
class Under:
    """What lies under a folder of recordings.

    Attributes:
        files: recordings, their parts, copies and exports, sorted: all with ``.mcap`` in the name.
        registers: the folders under it that have a register of their own; nothing in them counts.
        unseen: the folders that could not be looked into.
    """

    files: tuple[Path, ...]
    registers: tuple[Path, ...]
    unseen: tuple[Path, ...]


def under(folder: Path, names: Collection[str] = ()) -> Under:
    """Look through a folder and those under it; links to folders are not followed.

    Args:
        folder: where.
        names: of other files that are looked for too.
    """
    files: list[Path] = []
    registers: list[Path] = []
    unseen: list[Path] = []

    def not_seen(error: OSError) -> None:
        unseen.append(Path(error.filename))

    for place, folders, found in os.walk(folder, onerror=not_seen):
        here = Path(place)
        files += [here / name for name in found if ".mcap" in name or name in names]
        own = [name for name in folders if has_register(here / name)]
        registers += [here / name for name in own]
        # What is left in this list is walked through.
        folders[:] = [name for name in folders if name not in own]
    return Under(tuple(sorted(files)), tuple(sorted(registers)), tuple(sorted(unseen)))


def recordings_under(folder: Path) -> list[Path]:
    """Return the recordings that a folder's register speaks for, those not closed too."""
    return [path for path in under(folder).files if path.name.endswith((".mcap", ".mcap.part"))]


def register_folder(folder: Path) -> Path | None:
    """Return the folder whose register speaks for a folder: itself or the next one above it."""
    return next((place for place in and_above(folder) if has_register(place)), None)


def and_above(folder: Path) -> tuple[Path, ...]:
    """Return a folder and all those above it."""
    whole = folder.absolute()
    return (whole, *whole.parents)


def has_register(folder: Path) -> bool:
    """Whether a folder has a register; one that nobody may look into counts as having none."""
    # Unlike `Path.exists` this does not raise where it may not look.
    return os.path.exists(folder / FILE_NAME)  # noqa: PTH110
