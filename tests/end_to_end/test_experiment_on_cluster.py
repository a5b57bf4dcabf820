"""An experiment on a Dask cluster: a real scheduler, two workers, one killed in mid-run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from dask_cluster import ENVIRONMENT, count_workers, dask_process, free_port
from patience import PATIENCE_S
from small_experiment import small_experiment
from study.trial_files import read_results, results_sha256

pytest.importorskip("distributed", reason="needs the extra cluster")
TRIALS = 6


@pytest.mark.acceptance
def test_a_worker_killed_in_mid_run_changes_nothing(tmp_path: Path) -> None:
    """The other worker takes its trials over; results are those of one process here."""
    protocol = small_experiment(tmp_path)
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    scheduler = ("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    worker = ("worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
    command = [sys.executable, "-m", "study.commands.main", "experiment", str(protocol)]
    command += ["--trials", str(TRIALS)]
    here, there = tmp_path / "here", tmp_path / "there"
    with (
        dask_process(*scheduler, folder=tmp_path),
        dask_process(*worker, folder=tmp_path) as first,
        dask_process(*worker, folder=tmp_path) as second,
    ):
        deadline = time.monotonic() + PATIENCE_S
        while count_workers(address) < 2:
            assert time.monotonic() < deadline
        run = subprocess.Popen(
            [*command, "-o", str(there), "--scheduler", address], env=ENVIRONMENT
        )
        while not list(there.glob("trial_*.json")):
            assert run.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
        os.kill(first.pid, signal.SIGKILL)
        assert len(list(there.glob("trial_*.json"))) < TRIALS, "killed too late to show anything"
        assert run.wait(timeout=PATIENCE_S) == 0
        assert second.poll() is None
    subprocess.run(
        [*command, "-o", str(here), "--jobs", "1"],
        check=True,
        timeout=PATIENCE_S,
        env=ENVIRONMENT,
        capture_output=True,
    )
    found = [read_results(folder) for folder in (here, there)]
    assert [len(each.trials) for each in found] == [TRIALS, TRIALS]
    assert results_sha256(found[0].trials) == results_sha256(found[1].trials)


def test_no_scheduler_is_one_message(tmp_path: Path) -> None:
    """An address where nobody answers is said so, without a traceback."""
    protocol = small_experiment(tmp_path)
    command = [sys.executable, "-m", "study.commands.main", "experiment", str(protocol)]
    command += ["-o", str(tmp_path / "x"), "--scheduler", f"tcp://127.0.0.1:{free_port()}"]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=PATIENCE_S, env=ENVIRONMENT, check=False
    )
    assert done.returncode == 2
    assert "no Dask scheduler answers" in done.stderr
    assert "Traceback" not in done.stderr
