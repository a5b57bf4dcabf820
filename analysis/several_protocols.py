"""What is said where recordings follow several protocols: which are where, and how to choose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path

_NAMED = 2
"""Files and folders of one protocol that are named."""


def protocols_in_words(files: Mapping[tuple[str, str], Sequence[Path]]) -> str:
    """Return a line for each protocol.

    Args:
        files: first files of sessions, by their protocol's SHA-256 and their study's name.
    """
    lines = []
    for (digest, study), paths in sorted(files.items()):
        folders = _some(sorted({str(path.parent) for path in paths}))
        names = _some([path.name for path in paths])
        many = f"{len(paths)} session{'s' * (len(paths) != 1)}"
        lines.append(f'  {digest[:12]}: {many} of "{study}" in {folders}: {names}')
    return "\n".join(lines)


def how_to_choose(files: Mapping[tuple[str, str], Sequence[Path]]) -> str:
    """Say what to give in place of recordings of several protocols; see `protocols_in_words`."""
    every = [path for paths in files.values() for path in paths]
    for (_, study), paths in sorted(files.items(), key=lambda item: item[0][1]):
        pattern = paths[0].parent / f"{study}_*.mcap"
        if {path for path in every if _matches(path, pattern)} == set(paths):
            given = f"by their folder or a pattern such as {pattern}"
            break
    else:
        given = "by their folder or their names"
    return f"Give those of one, {given}; or pool them on purpose with --pool-protocols."


def _matches(path: Path, pattern: Path) -> bool:
    return path.parent == pattern.parent and fnmatch(path.name, pattern.name)


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
