"""`study run` killed in phase three and resumed, driven by real X11 events."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

from participant import Participant
from patience import PATIENCE_S
from study.errors import StudyError
from study.events.events import StageEntered, TrialEnded, TrialStarted
from study.recording.parts import read_session
from study.verification import verify
from x11_driver import Hands, x_server

ROOT = Path(__file__).resolve().parents[2]


def start(display: str, folder: Path, *options: str) -> subprocess.Popen[bytes]:
    """Start a session in a window."""
    environment = {
        **os.environ,
        "DISPLAY": display,
        "SDL_VIDEODRIVER": "x11",
        "SDL_AUDIODRIVER": "dummy",
    }
    command = [sys.executable, "-m", "study.commands.main", "run", "protocols/smoke.toml"]
    return subprocess.Popen(
        [*command, "-p", "P01", "-o", str(folder), *options], env=environment, cwd=ROOT
    )


def kill_in_phase_three(study: subprocess.Popen[bytes], folder: Path) -> None:
    """Kill the study as soon as a trial of phase three has run for a moment."""
    while study.poll() is None:
        for path in folder.glob("*.mcap.part"):
            try:
                started = [r for _, r in read_session(path).records(TrialStarted.topic)]
            except StudyError:
                continue
            if any(isinstance(trial, TrialStarted) and trial.phase == 3 for trial in started):
                time.sleep(0.3)
                study.kill()
                return
        time.sleep(0.1)


def test_killed_session_is_resumed_by_real_events(tmp_path: Path) -> None:
    """After SIGKILL in phase three the session goes on in part 2, and is whole in the end."""
    with x_server() as display:
        study = start(display, tmp_path)
        hands = Hands(display)
        killer = threading.Thread(target=kill_in_phase_three, args=(study, tmp_path))
        killer.start()
        try:
            Participant(hands, tmp_path, study, mouse=False, seed=1).run(PATIENCE_S)
        finally:
            study.kill()
            killer.join()
        assert study.wait() == -9

        study = start(display, tmp_path, "--resume")
        try:
            Participant(hands, tmp_path, study, mouse=False, seed=2, part=2).run(PATIENCE_S)
        finally:
            study.terminate()
            status = study.wait(PATIENCE_S)
            hands.close()
    assert status == 0
    first, second = sorted(tmp_path.glob("*.mcap"))
    assert second.name == f"{first.stem}_part2.mcap"
    verdict = verify(second)
    assert verdict.matches, verdict.difference
    assert (verdict.parts, verdict.left_out_trials) == (2, 1)
    session = read_session(first)
    assert session.complete
    started = [r for _, r in session.records(TrialStarted.topic) if isinstance(r, TrialStarted)]
    places = [(trial.phase, trial.block, trial.condition, trial.trial) for trial in started]
    assert len(set(places)) == len(places)
    ended = [r for _, r in session.records(TrialEnded.topic) if isinstance(r, TrialEnded)]
    assert [trial.trial_id for trial in started] == [trial.trial_id for trial in ended]
    assert all(trial.complete for trial in ended)
    entered = [r for _, r in session.records(StageEntered.topic) if isinstance(r, StageEntered)]
    stages = [stage.stage for stage in entered]
    assert set(stages) == set(range(max(stages) + 1))
