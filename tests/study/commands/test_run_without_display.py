"""`study run` where no window can be opened."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from patience import PATIENCE_S
from study.enrolment.register import Register

ROOT = Path(__file__).resolve().parents[3]


def test_no_display_is_one_message_and_leaves_nothing(tmp_path: Path) -> None:
    """Without a display the user gets one message, status 2 and no empty recording."""
    environment = {**os.environ, "DISPLAY": "", "SDL_VIDEODRIVER": "x11"}
    folder = tmp_path / "recordings"
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "study.commands.main",
            "run",
            "smoke",
            "-p",
            "P1",
            "-o",
            str(folder),
        ],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 2
    assert "no window can be opened" in done.stderr
    assert "Traceback" not in done.stderr
    # The reservation is given back.
    (left,) = folder.iterdir()
    assert left.name == "participants.sqlite"
    with Register(folder) as register:
        assert register.participants() == []
