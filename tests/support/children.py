"""The processes that a running study has started, as Linux tells them."""

from __future__ import annotations

import subprocess
from pathlib import Path


def child_of(study: subprocess.Popen[str], module: str) -> int:
    """Return the process id of the study's one child that runs a module."""
    children = Path(f"/proc/{study.pid}/task/{study.pid}/children").read_text().split()
    (found,) = [
        int(child)
        for child in children
        if module.encode() in Path(f"/proc/{child}/cmdline").read_bytes()
    ]
    return found
