"""The study's commands as they are typed: a process of its own for each."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from patience import PATIENCE_S
from protocols import ROOT
from warm_program import WarmProgram

_warm: list[WarmProgram] = []


def study(
    *arguments: str | Path, folder: Path = ROOT, environment: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command, without a display, and return what it said.

    It must not have ended in a traceback.

    Args:
        arguments: the command's.
        folder: in which it runs.
        environment: variables to set for it.
    """
    variables = {
        **os.environ,
        # Extras may be elsewhere.
        "PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), os.getenv("PYTHONPATH")])),
        "SDL_VIDEODRIVER": "dummy",
        **(environment or {}),
    }
    if environment is None and sys.platform != "win32":
        done = _warm_for(variables).run([*map(str, arguments)], folder, PATIENCE_S)
    else:
        done = subprocess.run(
            [sys.executable, "-m", "study.commands.main", *map(str, arguments)],
            cwd=folder,
            env=variables,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


def _warm_for(variables: Mapping[str, str]) -> WarmProgram:
    """Return the program that has imported what commands need, under these variables."""
    if not (_warm and _warm[0].serves(variables)):
        _warm[:] = [WarmProgram(variables)]
    return _warm[0]
