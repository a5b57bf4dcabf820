"""The processes that a running study has started, as Linux tells them."""

from __future__ import annotations

import contextlib
import subprocess
import time
from pathlib import Path

from patience import PATIENCE_S


def child_of(study: subprocess.Popen[str], module: str) -> int:
    """Return the process id of the study's one child that runs a module."""
    deadline = time.monotonic() + PATIENCE_S
    # One that has just been started does not run the module yet.
    while not (found := _children_of(study.pid, module)):
        assert time.monotonic() < deadline, f"no child runs {module}"
        time.sleep(0.05)
    (child,) = found
    return child


def _children_of(parent: int, module: str) -> list[int]:
    found = []
    for child in Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            if module.encode() in Path(f"/proc/{child}/cmdline").read_bytes():
                found.append(int(child))
    return found
