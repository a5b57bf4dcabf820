"""Which process holds a lease, and whether it still lives.

A number alone does not tell: numbers are given out again. With the process's start time and the
machine's boot it names one process for good.
"""

from __future__ import annotations

import dataclasses
import os
import platform
import subprocess
import sys
from pathlib import Path


@dataclasses.dataclass(frozen=True, slots=True)
class ProcessIdentity:
    """One process.

    Attributes:
        host: name of the machine.
        pid: the process's number there.
        started: what tells it from others of that number; empty where that cannot be had.
    """

    host: str
    pid: int
    started: str


def this_process() -> ProcessIdentity:
    """Return the identity of the calling process."""
    return ProcessIdentity(platform.node(), os.getpid(), _started(os.getpid()) or "")


def is_alive(process: ProcessIdentity) -> bool | None:
    """Return whether a process lives; None if it cannot be told, as of another machine's."""
    if process.host != platform.node():
        return None
    if sys.platform == "win32":
        return True if process.pid == os.getpid() else None
    try:
        os.kill(process.pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    started = _started(process.pid)
    if started is None:
        return False
    if not started or not process.started:
        return None
    return started == process.started


def _started(pid: int) -> str | None:
    """Return what tells a process from others of its number; empty if unknown, None if dead."""
    if sys.platform == "linux":
        try:
            stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
            boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        except (FileNotFoundError, ProcessLookupError):
            return None
        except OSError:
            return ""
        # The name may hold blanks and parentheses; state and start time stand after it.
        fields = stat.rpartition(")")[2].split()
        return None if fields[0] in ("Z", "X") else f"{boot}/{fields[19]}"
    if sys.platform == "darwin":
        done = subprocess.run(
            ["/bin/ps", "-o", "lstart=", "-p", str(pid)],
            capture_output=True,
            text=True,
            check=False,
        )
        return done.stdout.strip() or None
    return ""
