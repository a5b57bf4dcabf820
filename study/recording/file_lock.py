"""Tells a file that is being written from one whose writer is gone.

The writer holds an advisory lock for as long as it lives; the system lets go of it however the
writer ends. Loaded by the writer process, so it imports the standard library only.
"""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path

if sys.platform != "win32":
    import fcntl

    def hold(descriptor: int) -> None:
        """Hold the lock of an open file until it is closed, where the file system has locks."""
        with contextlib.suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def is_held(path: Path) -> bool:
        """Return whether a living process holds the lock of a file."""
        try:
            with path.open("rb") as stream:
                fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:
            return False
        return False

else:

    def hold(descriptor: int) -> None:
        """Do nothing: such locks would keep others from reading here."""

    def is_held(path: Path) -> bool:  # noqa: ARG001 - the same question on every platform
        """Return False: it cannot be told."""
        return False
