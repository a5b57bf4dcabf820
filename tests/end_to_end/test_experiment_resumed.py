"""An experiment survives what befalls it: a kill, a damaged file, other numbers of workers."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from patience import PATIENCE_S
from protocols import ROOT
from small_experiment import small_experiment
from study.trial_files import read_results, results_sha256

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
TRIALS = 5


def _command(protocol: Path, folder: Path, *more: str) -> list[str]:
    arguments = [str(protocol), "-o", str(folder), "--trials", str(TRIALS), *more]
    return [sys.executable, "-m", "study.commands.main", "experiment", *arguments]


def _hash(folder: Path) -> str:
    found = read_results(folder)
    assert found.damaged == ()
    assert [each.trial for each in found.trials] == list(range(TRIALS))
    return results_sha256(found.trials)


@pytest.mark.acceptance
def test_a_killed_run_goes_on_and_nothing_differs(tmp_path: Path) -> None:
    """SIGKILL in mid-run, then a damaged file: the same results, and only those run again."""
    protocol = small_experiment(tmp_path)
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    subprocess.run(
        _command(protocol, whole, "--jobs", "1"),
        check=True,
        timeout=PATIENCE_S,
        env=ENVIRONMENT,
        capture_output=True,
    )

    process = subprocess.Popen(
        _command(protocol, killed, "--jobs", "2"),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=ENVIRONMENT,
        start_new_session=True,
    )
    deadline = time.monotonic() + PATIENCE_S
    while not list(killed.glob("trial_*.json")):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    there = sorted(killed.glob("trial_*.json"))
    assert 0 < len(there) < TRIALS, "it was killed too late to show anything"
    kept = {path: path.stat().st_mtime_ns for path in there[1:]}
    there[0].write_text(there[0].read_text()[:-20])

    done = subprocess.run(
        _command(protocol, killed, "--jobs", "2"),
        check=True,
        timeout=PATIENCE_S,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
    )
    assert _hash(killed) == _hash(whole)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert f"{len(kept)} were there" in done.stdout or not kept
