"""An experiment on a Dask cluster: a real scheduler, two workers, one killed in mid-run."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from patience import PATIENCE_S
from protocols import ROOT
from small_experiment import small_experiment
from study.trial_files import read_results, results_sha256

pytest.importorskip("distributed", reason="needs the extra cluster")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
TRIALS = 6


@contextlib.contextmanager
def _process(*arguments: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start a Dask program and end it, whatever happens; no nanny restarts it."""
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=ENVIRONMENT,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _workers(address: str) -> int:
    import distributed

    cluster: Any = distributed

    with (
        contextlib.suppress(OSError, TimeoutError),
        cluster.Client(address, timeout="2s", set_as_default=False) as client,
    ):
        return len(client.scheduler_info(n_workers=-1)["workers"])
    return 0


def test_a_worker_killed_in_mid_run_changes_nothing(tmp_path: Path) -> None:
    """The other worker takes its trials over; results are those of one process here."""
    protocol = small_experiment(tmp_path)
    port = _free_port()
    address = f"tcp://127.0.0.1:{port}"
    scheduler = ("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    worker = ("worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
    command = [sys.executable, "-m", "study.commands.main", "experiment", str(protocol)]
    command += ["--trials", str(TRIALS)]
    here, there = tmp_path / "here", tmp_path / "there"
    with (
        _process(*scheduler, folder=tmp_path),
        _process(*worker, folder=tmp_path) as first,
        _process(*worker, folder=tmp_path) as second,
    ):
        deadline = time.monotonic() + PATIENCE_S
        while _workers(address) < 2:
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
    command += ["-o", str(tmp_path / "x"), "--scheduler", f"tcp://127.0.0.1:{_free_port()}"]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=PATIENCE_S, env=ENVIRONMENT, check=False
    )
    assert done.returncode == 2
    assert "no Dask scheduler answers" in done.stderr
    assert "Traceback" not in done.stderr
