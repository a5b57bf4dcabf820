"""A session in a real window, driven by real X11 events from welcome to thanks."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from analysis.commands.report import write_report
from participant import Participant
from patience import PATIENCE_S
from protocols import ROOT
from study.events.inputs import KeyChanged
from study.recording.parts import read_whole_session
from study.verification import verify
from x11_driver import Hands, x_server


def run_session(
    protocol: str, folder: Path, *, mouse: bool, timeout_s: float
) -> tuple[Path, list[tuple[str, bool]]]:
    """Run a session by real events; return its recording and the key events sent."""
    with x_server() as display:
        environment = {
            **os.environ,
            "DISPLAY": display,
            "SDL_VIDEODRIVER": "x11",
            "SDL_AUDIODRIVER": "dummy",
        }
        command = [sys.executable, "-m", "study.commands.main", "run", protocol, "-p", "P01"]
        study = subprocess.Popen([*command, "-o", str(folder)], env=environment, cwd=ROOT)
        hands = Hands(display)
        try:
            Participant(hands, folder, study, mouse=mouse, seed=1).run(timeout_s)
        finally:
            study.terminate()
            status = study.wait(PATIENCE_S)
            hands.close()
    assert status == 0
    (recording,) = folder.glob("*.mcap")
    return recording, hands.sent


def check(path: Path, sent: list[tuple[str, bool]], report: Path) -> None:
    """Check what every driven session must leave: keys as sent, a replay, a report."""
    # On a busy machine the writer may have been replaced: the session then has parts.
    recording = read_whole_session(path)
    assert recording.complete
    keys = [
        (record.key, record.down)
        for _, record in recording.records("input/key_changed")
        if isinstance(record, KeyChanged)
    ]
    assert keys == sent
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    answers = list(recording.records("event/question_answered"))
    assert len(answers) == 8
    page = write_report([path.parent], report).read_text()
    assert "P01" in page
    assert "Simulated participants" not in page
