"""Packages of Node that a test needs, installed once from their lock file."""

from __future__ import annotations

import fcntl
import hashlib
import os
import subprocess
from pathlib import Path

import pytest

from patience import PATIENCE_S
from x11_driver import require_program


def install_packages(folder: Path) -> None:
    """Install what a folder's lock file names, whoever of several test workers comes first.

    Without a network the test is skipped, but fails in CI.
    """
    npm = require_program("npm")
    wanted = hashlib.sha256((folder / "package-lock.json").read_bytes()).hexdigest()
    stamp = folder / "node_modules" / ".lock-sha256"
    with (folder / "package.json").open("rb") as gate:
        fcntl.flock(gate, fcntl.LOCK_EX)
        if stamp.is_file() and stamp.read_text() == wanted:
            return
        command = [npm, "ci", "--no-audit", "--no-fund", "--ignore-scripts"]
        try:
            done = subprocess.run(
                command,
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
                timeout=PATIENCE_S,
            )
            failure = done.stderr if done.returncode else ""
        except subprocess.TimeoutExpired:
            failure = f"it took more than {PATIENCE_S:g} s"
        if failure:
            reason = f"npm ci failed in {folder}: {failure}"
            if os.environ.get("CI"):
                pytest.fail(reason)
            pytest.skip(reason)
        stamp.write_text(wanted)
