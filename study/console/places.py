"""Where running sessions can be found: sockets in a folder that only their user can enter."""

from __future__ import annotations

import contextlib
import os
import re
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from study.errors import StudyError

FOLDER = "scaled-autonomy"
SUFFIX = ".sock"
MOST_SESSIONS = 64
LONGEST_PATH = 100
"""Bytes of a socket's path; systems take 104 to 108."""
_SESSION_ID = re.compile(r"[0-9a-zA-Z_-]{1,64}")


def candidates() -> list[Path]:
    """Return the folders in which a session may have its socket, the preferred one first."""
    if os.name != "posix":
        return []
    user = os.getuid()
    temporary = Path(tempfile.gettempdir()) / f"{FOLDER}-{user}"
    runtime = Path(os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{user}")
    return [runtime / FOLDER, temporary] if runtime.is_dir() else [temporary]


def is_private(folder: Path) -> bool:
    """Whether a folder is a real one, ours, and closed to everybody else."""
    try:
        facts = folder.lstat()
    except OSError:
        return False
    ours = stat.S_ISDIR(facts.st_mode) and facts.st_uid == os.getuid()
    return ours and not facts.st_mode & 0o077


def socket_path(session_id: str) -> Path:
    """Return where a session's socket goes; its folder is made if need be.

    Raises:
        StudyError: no folder can be had that is private.
    """
    if os.name != "posix":
        raise StudyError("a console needs sockets of Linux or macOS")
    if not _SESSION_ID.fullmatch(session_id):
        raise StudyError(f'"{session_id}" is no session\'s identifier')
    tried = []
    for folder in candidates():
        path = folder / f"{session_id}{SUFFIX}"
        if len(os.fsencode(path)) > LONGEST_PATH:
            tried.append(f"{folder}: its path is too long")
            continue
        try:
            folder.mkdir(mode=0o700, exist_ok=True)
        except OSError as error:
            tried.append(f"{folder}: {error.strerror}")
            continue
        if is_private(folder):
            return path
        tried.append(f"{folder}: it is not a folder of yours alone")
    raise StudyError(
        f"no folder for the console's socket: {'; '.join(tried)}",
        "Set XDG_RUNTIME_DIR to a short path of a folder of yours.",
    )


def sockets() -> Iterator[Path]:
    """Yield the sockets there are, sessions that have ended included, newest first."""
    found: list[tuple[float, Path]] = []
    for folder in candidates():
        if not is_private(folder):
            continue
        with contextlib.suppress(OSError):
            for path in folder.iterdir():
                facts = path.lstat()
                if path.suffix == SUFFIX and stat.S_ISSOCK(facts.st_mode):
                    found.append((facts.st_mtime, path))
    for _, path in sorted(found, reverse=True)[:MOST_SESSIONS]:
        yield path
