"""A whole study in DOOM: in a real window, and with engines that are killed throughout."""

from __future__ import annotations

import os
import random
import signal
import threading
import uuid
from pathlib import Path

import pytest

from analysis.recordings import load_recordings
from analysis.tables.study_tables import StudyTables
from command_line import study
from driven_session import check, run_session
from extras import need
from patience import PATIENCE_S
from protocols import ROOT, in_doom
from study.events.events import Deviation, SessionEnded, TrialEnded
from study.events.inputs import RobotReported
from study.events.shell import DisplayOpened
from study.recording.reader import read_recording
from study.verification import verify

BETWEEN_KILLS_S = 4.0
"""Longer than it takes to replace half a dozen engines: three failures in a row end a session."""
SEED = 11


def test_without_the_engine_it_is_said_what_to_install(tmp_path: Path) -> None:
    """The protocol is valid; to run or to simulate it names the package, and records nothing."""
    (tmp_path / "sitecustomize.py").write_text('import sys\nsys.modules["vizdoom"] = None\n')
    without = {"PYTHONPATH": f"{tmp_path}:{ROOT}"}
    validated = study("validate", "doom", environment=without)
    assert validated.returncode == 0
    assert "scaled-autonomy[doom]" in validated.stdout
    for command in (("run", "doom", "-p", "P01"), ("simulate", "doom", "--participants", "1")):
        done = study(*command, "-o", tmp_path / "out", environment=without)
        assert done.returncode == 2
        assert "scaled-autonomy[doom]" in done.stderr
        assert "forbids commercial use" in done.stderr
    assert not list((tmp_path / "out").glob("*.mcap*"))


@pytest.mark.acceptance
@pytest.mark.parametrize("base", ["smoke", "pilot"])
def test_a_protocol_in_doom_by_real_events(tmp_path: Path, base: str) -> None:
    """In a real window every stage is passed by real keys, and the recording replays."""
    need("vizdoom")
    folder = tmp_path / "recordings"
    path, sent = run_session(
        str(in_doom(tmp_path, base=base)), folder, mouse=False, timeout_s=1.5 * PATIENCE_S
    )
    check(path, sent, tmp_path / "report")
    recording = read_recording(path)
    assert [record.driver for _, record in recording.records("shell/display")
            if isinstance(record, DisplayOpened)] == ["x11"]  # fmt: skip
    trials = [r for _, r in recording.records("event/trial_ended") if isinstance(r, TrialEnded)]
    assert all(trial.complete for trial in trials)


def _processes(mark: str) -> list[int]:
    """Return the workers and engines of DOOM with a mark in their environment."""
    found = []
    for environment in Path("/proc").glob("[0-9]*/environ"):
        try:
            marked = mark.encode() in environment.read_bytes()
            command = (environment.parent / "cmdline").read_text()
        except OSError:
            continue
        if marked and ("_doom.worker" in command or "map.wad" in command):
            found.append(int(environment.parent.name))
    return found


class _Killer(threading.Thread):
    """Kills or stops a worker or an engine at random, over and over."""

    def __init__(self, mark: str) -> None:
        super().__init__()
        self._mark = mark
        self._random = random.Random(SEED)
        self.ending = threading.Event()
        self.killed = 0

    def run(self) -> None:
        """Go on until told otherwise."""
        while not self.ending.wait(self._random.uniform(0.5, 1.5) * BETWEEN_KILLS_S):
            victims = _processes(self._mark)
            if not victims:
                continue
            how = self._random.choice([signal.SIGKILL, signal.SIGSTOP])
            try:
                os.kill(self._random.choice(sorted(victims)), how)
            except ProcessLookupError:
                continue
            self.killed += 1


@pytest.mark.acceptance
def test_a_session_survives_engines_that_are_killed(tmp_path: Path) -> None:
    """The session ends whole, its trials are flagged, and events and states are as ever."""
    need("vizdoom")
    mark = uuid.uuid4().hex
    protocol = in_doom(tmp_path, ("trial_timesteps = 40", "trial_timesteps = 150"))
    killer = _Killer(mark)
    killer.start()
    try:
        done = study(
            "simulate", protocol, "--participants", "1", "-o", tmp_path / "out",
            environment={"PYTHONPATH": os.environ.get("PYTHONPATH", str(ROOT)), "DOOM_MARK": mark},
        )  # fmt: skip
    finally:
        killer.ending.set()
        killer.join()
    assert done.returncode == 0, done.stderr
    assert killer.killed >= 3
    path = next((tmp_path / "out").glob("*.mcap"))
    records = [record for _, record in read_recording(path).records()]
    assert [r.complete for r in records if isinstance(r, SessionEnded)] == [True]
    assert all(r.complete for r in records if isinstance(r, TrialEnded))
    reports = [r for r in records if isinstance(r, RobotReported)]
    assert {report.reason for report in reports} == {"engine_lost"}
    # Whoever lost an engine has one again.
    for robot in {report.robot for report in reports}:
        mine = [report.stopped for report in reports if report.robot == robot]
        assert mine == [True, False] * (len(mine) // 2)
    deviations = [r for r in records if isinstance(r, Deviation) and r.code == "robot_stopped"]
    assert len(deviations) == sum(report.stopped for report in reports)
    assert any(deviation.trial_id >= 0 for deviation in deviations)
    assert all("DOOM engine failed" in deviation.text for deviation in deviations)
    # In the analysis the trials are marked, so that a rule can leave them out.
    trials = StudyTables(load_recordings([path])).frame("trials")
    flagged = set(trials.loc[trials["deviations"] == "robot_stopped", "trial_id"])
    assert flagged == {deviation.trial_id for deviation in deviations} - {-1}
    verdict = verify(path, resimulate=True)
    assert verdict.matches, verdict.difference
    assert verdict.largest_deviation == 0.0
    assert not _processes(mark)
