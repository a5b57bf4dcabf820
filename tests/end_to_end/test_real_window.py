"""`study run` in a real window, driven by real X11 events."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from analysis.commands.report import write_report
from participant import Participant
from patience import PATIENCE_S
from protocols import variant
from study.events.inputs import KeyChanged
from study.recording.reader import read_recording
from study.verification import verify
from x11_driver import Hands, x_server

ROOT = Path(__file__).resolve().parents[2]


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
    recording = read_recording(path)
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
    page = write_report([path], report).read_text()
    assert "P01" in page
    assert "Simulated participants" not in page


@pytest.mark.parametrize(
    "mouse",
    [
        pytest.param(False, id="keyboard"),
        pytest.param(True, id="mouse", marks=pytest.mark.acceptance),
    ],
)
def test_smoke_protocol_by_real_events(tmp_path: Path, mouse: bool) -> None:
    """Every stage is passed, each key sent is recorded in order, and a report is built."""
    folder = tmp_path / "recordings"
    path, sent = run_session("protocols/smoke.toml", folder, mouse=mouse, timeout_s=PATIENCE_S)
    check(path, sent, tmp_path / "report")


@pytest.mark.acceptance
def test_pilot_protocol_by_real_events(tmp_path: Path) -> None:
    """The ten-minute pilot is driven from welcome to thanks in real time."""
    folder = tmp_path / "recordings"
    path, sent = run_session("protocols/pilot.toml", folder, mouse=True, timeout_s=1500)
    check(path, sent, tmp_path / "report")
    assert len(sent) > 500


SHORT_CARTS = (
    ("episodes = 4", "episodes = 1"),
    ("timesteps = 200", "timesteps = 20"),
    ("trials = 2", "trials = 1"),
    ("trial_timesteps = 300", "trial_timesteps = 60"),
    ("epochs = 100", "epochs = 2"),
    ("at_least = 4", "at_least = 2"),
)


def test_gymnasium_by_real_events(tmp_path: Path) -> None:
    """Carts of Gymnasium are driven in a window: every key sent is recorded, and it replays."""
    pytest.importorskip("gymnasium")
    carts = variant(tmp_path, *SHORT_CARTS, base="cart_pole")
    folder = tmp_path / "recordings"
    path, sent = run_session(str(carts), folder, mouse=False, timeout_s=2 * PATIENCE_S)
    check(path, sent, tmp_path / "report")
    assert any(key in ("left", "right") for key, _ in sent)
