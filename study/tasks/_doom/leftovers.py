"""What the engine's library would leave behind: named shared memory, once a process is killed.

While an engine runs its memory has no name any more (`forget_memory`). What is left are engines
killed while they start: whoever kills one knows its memory (`memory_of`), and of those killed by
others the next fleet takes it away (`sweep_memory`).
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path

_MEMORY = Path("/dev/shm")  # noqa: S108 - where the engine's library keeps its memory on Linux
_PATTERN = "ViZDoom*"

_MAKING_SECONDS = 2.0
"""Memory that is younger may be that of an engine which has not opened it yet."""


def forget_memory(instance: str) -> None:
    """Remove the names of an engine's memory, which both sides have open by now.

    The memory then ends with the processes, however they end.
    """
    for path in _MEMORY.glob(f"{_PATTERN}{instance}"):
        path.unlink(missing_ok=True)


def memory_of(pid: int) -> list[Path]:
    """Return the named memory that a process has open."""
    with contextlib.suppress(OSError):
        maps = Path(f"/proc/{pid}/maps").read_text()
        return [path for path in _MEMORY.glob(_PATTERN) if str(path) in maps]
    return []


def sweep_memory() -> None:
    """Remove memory of engines whose process was killed while they started.

    Only what is ours, what no process has open and what is not just being made.
    """
    for path in _MEMORY.glob(_PATTERN):
        with contextlib.suppress(OSError):
            made = path.stat()
            ours = made.st_uid == os.getuid()
            if ours and time.time() - made.st_mtime > _MAKING_SECONDS and not _is_open(path):
                path.unlink()


def _is_open(path: Path) -> bool:
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with contextlib.suppress(OSError):
            if str(path) in maps.read_text():
                return True
    return False
