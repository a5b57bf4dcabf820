"""From keys to a verified recording: with an exact task and with one that is never exact."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from patience import PATIENCE_S
from protocols import erratic, variant
from study.commands.simulating import simulate_session, simulated_assignments
from study.events.events import Timestep, TrialEnded
from study.events.inputs import FleetObserved, TimestepDue
from study.loading import load_protocol
from study.recording.reader import read_recording
from study.verification import verify

ROOT = Path(__file__).resolve().parents[2]


def simulated(protocol: Path, folder: Path) -> Path:
    """Record one simulated participant."""
    (assignment,) = simulated_assignments(load_protocol(str(protocol)), 1, seed=5)
    return simulate_session(str(protocol), assignment, 5, folder)


@pytest.fixture(scope="module")
def navigation(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated session with the exact task."""
    folder = tmp_path_factory.mktemp("navigation")
    return simulated(variant(folder), folder / "r")


def test_navigation_replays_and_steps_anew(navigation: Path) -> None:
    """The exact task's events replay byte for byte, and stepping it again gives the same."""
    verdict = verify(navigation, resimulate=True)
    assert verdict.matches, verdict.difference
    assert verdict.events > 100
    assert verdict.resimulated > 100
    assert verdict.largest_deviation == 0.0


def test_erratic_task_replays(tmp_path: Path) -> None:
    """A task in another process that is never twice the same replays byte for byte too."""
    path = simulated(erratic(tmp_path), tmp_path / "r")
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    assert verdict.events > 100
    again = verify(path, resimulate=True)
    assert not again.matches
    assert "erratic" in again.difference


def test_replay_notices_a_changed_event(navigation: Path) -> None:
    """A recording whose events do not follow from its inputs is not called identical."""
    from study.events import events
    from study.recording import reader
    from study.recording.wire import decode, encode
    from study.verification import verify_recording

    recording = read_recording(navigation)
    rows = list(recording.raw("input", "event"))
    place = next(i for i, raw in enumerate(rows) if raw.topic == "event/trial_ended")
    ended = decode(rows[place].topic, rows[place].data)
    assert isinstance(ended, TrialEnded)
    forged = events.TrialEnded(
        ended.t_ns, ended.trial_id, ended.timesteps, ended.team_reward + 1e-9, ended.complete
    )
    old = rows[place]
    rows[place] = reader.RawRecord(old.sequence, old.topic, old.log_time_ns, encode(forged))

    class Forged:
        losses: tuple[()] = ()
        complete = True

        def raw(self, *families: str) -> list[reader.RawRecord]:
            return rows

    verdict = verify_recording(Forged())  # type: ignore[arg-type]
    assert not verdict.matches
    assert "team_reward" in verdict.difference


def has_begun(folder: Path) -> bool:
    """Whether a recording holds more than its own beginning."""
    return any(path.stat().st_size > 30_000 for path in folder.glob("*.part"))


@pytest.mark.parametrize("task", ["navigation", "erratic"])
@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.acceptance) for seed in (2, 3))]
)
def test_killed_study_leaves_a_whole_recording(tmp_path: Path, task: str, seed: int) -> None:
    """SIGKILL at a random moment: the file is finished, and replays to its last input."""
    protocol = erratic(tmp_path) if task == "erratic" else variant(tmp_path, base="scaled_autonomy")
    folder = tmp_path / "recordings"
    script = ROOT / "tests" / "support" / "killable_session.py"
    study = subprocess.Popen([sys.executable, str(script), str(protocol), str(folder)], cwd=ROOT)
    deadline = time.monotonic() + PATIENCE_S
    while not has_begun(folder) and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(random.Random(seed).uniform(0.0, 1.0))
    study.send_signal(signal.SIGKILL)
    study.wait(10)
    deadline = time.monotonic() + PATIENCE_S
    while not list(folder.glob("*.mcap")) and time.monotonic() < deadline:
        time.sleep(0.02)
    (path,) = folder.glob("*.mcap")
    recording = read_recording(path)
    assert recording.complete, recording.problems
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    assert not any(True for _ in recording.records("event/session_ended"))


def test_every_timestep_has_its_cause(navigation: Path) -> None:
    """Each recorded timestep stands between its due time and the fleet's answer."""
    recording = read_recording(navigation)
    due = {r.t_ns for _, r in recording.records("input/timestep_due") if isinstance(r, TimestepDue)}
    answers = {
        r.t_ns for _, r in recording.records("input/fleet_observed") if isinstance(r, FleetObserved)
    }
    rows = [r for _, r in recording.records("event/timestep") if isinstance(r, Timestep)]
    assert rows
    assert all(row.due_ns in due and row.t_ns in answers for row in rows)
    assert recording.path.stat().st_mode & 0o777 == 0o600
