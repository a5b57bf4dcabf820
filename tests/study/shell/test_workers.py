"""Worker processes answer, fail in words, and leave no orphan."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from operator import attrgetter, methodcaller
from pathlib import Path
from typing import Any

import pytest

from study.errors import StudyError
from study.shell.workers import Worker, WorkerFailure


def is_running(pid: int) -> bool:
    """Whether a process runs (a zombie does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.fixture
def worker() -> Iterator[Worker]:
    """A worker that answers a text with its upper case, and fails at anything else."""
    made = Worker(methodcaller, "upper")
    yield made
    made.close()


def pid_of(worker: Worker) -> int:
    """Return the number of the worker's process."""
    pid = attrgetter("_process.pid")(worker)
    assert isinstance(pid, int)
    return pid


def answer(worker: Worker) -> Any:
    """Wait for an answer."""
    return worker.poll(20.0)


def test_answers_in_order(worker: Worker) -> None:
    """Each request is answered once, first come first served."""
    worker.send("a")
    worker.send("b")
    assert (answer(worker), answer(worker)) == ("A", "B")
    assert worker.poll() is None


def test_failure_is_an_answer_and_the_worker_goes_on(worker: Worker) -> None:
    """What raises is answered with its reason."""
    worker.send(5)
    failed = answer(worker)
    assert isinstance(failed, WorkerFailure)
    assert "upper" in failed.reason
    worker.send("a")
    assert answer(worker) == "A"


def test_killed_process_is_said_to_be_gone(worker: Worker) -> None:
    """Polling and sending say that the process ended, instead of waiting for ever."""
    worker.send("a")
    assert answer(worker) == "A"
    os.kill(pid_of(worker), signal.SIGKILL)
    with pytest.raises(StudyError, match="ended unexpectedly"):
        worker.poll(10.0)
    with pytest.raises(StudyError, match="ended unexpectedly"):
        worker.send("a")


def test_interrupt_while_it_imports_is_no_traceback(capfd: pytest.CaptureFixture[str]) -> None:
    """A process that only begins is not reached by Ctrl-C either."""
    for delay in (0.0, 0.02, 0.05, 0.1):
        worker = Worker(methodcaller, "upper")
        try:
            time.sleep(delay)
            os.kill(pid_of(worker), signal.SIGINT)
            worker.send("a")
            assert answer(worker) == "A"
        finally:
            worker.close()
    assert capfd.readouterr().err == ""


def test_interrupt_leaves_the_worker_to_the_study(worker: Worker) -> None:
    """Ctrl-C reaches the whole terminal group; the study decides what ends."""
    worker.send("a")
    assert answer(worker) == "A"
    os.kill(pid_of(worker), signal.SIGINT)
    worker.send("b")
    assert answer(worker) == "B"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
def test_close_leaves_no_process() -> None:
    """Neither an idle worker nor a busy one outlives its owner's close, called once or twice."""
    idle, busy = Worker(methodcaller, "upper"), Worker(_sleeper)
    for worker in (idle, busy):
        worker.send("a" if worker is idle else 60.0)
    assert answer(idle) == "A"
    pids = [pid_of(idle), pid_of(busy)]
    assert all(map(is_running, pids))
    for worker in (idle, busy):
        worker.close()
        worker.close()
    assert not any(map(is_running, pids))


def _sleeper() -> Any:
    return time.sleep


def test_what_cannot_be_made_is_said_to_whoever_asks() -> None:
    """A process whose object cannot be made says why, each time, and prints no traceback."""
    made = Worker(methodcaller)
    try:
        for _ in range(2):
            made.send("a")
            failed = answer(made)
            assert isinstance(failed, WorkerFailure)
            assert "method name" in failed.reason
    finally:
        made.close()
