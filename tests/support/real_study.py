"""`study run` as a program of its own, in a window on a virtual X server."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from patience import PATIENCE_S
from x11_driver import Hands, x_server

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def real_study(
    protocol: str,
    folder: Path,
    *options: str,
    display_size: tuple[int, int] = (1280, 960),
    program: tuple[str, ...] = ("-m", "study.commands.main"),
) -> Iterator[tuple[Hands, subprocess.Popen[bytes]]]:
    """Run participant P01's session; yield hands at its window, and the program.

    Args:
        protocol: its name or file.
        folder: where the recording goes.
        options: more of the command's.
        display_size: of the virtual screen, pixels.
        program: what Python runs, if not the study's own command.
    """
    with x_server(*display_size) as display:
        environment = {
            **os.environ,
            "DISPLAY": display,
            "SDL_VIDEODRIVER": "x11",
            "SDL_AUDIODRIVER": "dummy",
            "PYTHONPATH": str(ROOT),
        }
        command = [sys.executable, *program, "run", protocol, "-p", "P01"]
        study = subprocess.Popen([*command, "-o", str(folder), *options], env=environment, cwd=ROOT)
        hands = Hands(display)
        try:
            yield hands, study
        finally:
            study.terminate()
            study.wait(PATIENCE_S)
            hands.close()
