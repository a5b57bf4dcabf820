"""`study run` as a program of its own, in a window on a virtual X server."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from patience import PATIENCE_S, until
from x11_driver import Hands, x_server

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def real_study(
    protocol: str,
    folder: Path,
    *options: str,
    display_size: tuple[int, int] = (1280, 960),
    program: Sequence[str] = ("-m", "study.commands.main"),
    participant: str = "P01",
    said: IO[bytes] | None = None,
) -> Iterator[tuple[Hands, subprocess.Popen[bytes]]]:
    """Run a participant's session; yield hands at its window, and the program.

    Args:
        protocol: its name or file.
        folder: where the recording goes.
        options: more of the command's.
        display_size: of the virtual screen, pixels.
        program: what Python runs, if not the study's own command.
        participant: whose session.
        said: file for what the program says; None: where this process says it.
    """
    with x_server(*display_size) as display:
        environment = {
            **os.environ,
            "DISPLAY": display,
            "SDL_VIDEODRIVER": "x11",
            "SDL_AUDIODRIVER": "dummy",
            # Extras may be elsewhere.
            "PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), os.getenv("PYTHONPATH")])),
        }
        command = [sys.executable, *program, "run", protocol, "-p", participant]
        command += ["-o", str(folder), *options]
        study = subprocess.Popen(
            command,
            env=environment,
            cwd=ROOT,
            stdout=said,
            stderr=subprocess.STDOUT if said else None,
        )
        hands = Hands(display)
        try:
            yield hands, study
        finally:
            study.terminate()
            study.wait(PATIENCE_S)
            hands.close()


def close_last_words(hands: Hands, study: subprocess.Popen[bytes]) -> int:
    """Press Enter until a session that has ended closes its window; return its status."""

    def over() -> bool:
        if study.poll() is None:
            hands.tap("return")
        return study.poll() is not None

    until(over)
    return study.wait()
