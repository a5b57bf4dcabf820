"""The register under real processes: many that start at once, and some that are killed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from patience import PATIENCE_S
from protocols import ROOT
from reserving_process import ORDERS
from study.enrolment.process_identity import ProcessIdentity, is_alive, this_process
from study.enrolment.register import Register
from study.errors import StudyError

PROGRAM = ROOT / "tests" / "support" / "reserving_process.py"


@contextmanager
def reserving(folder: Path, number: int) -> Iterator[list[tuple[subprocess.Popen[str], list[str]]]]:
    """Let processes reserve at the same moment; yield each with what it got. All live on."""
    signal = folder / "go"
    processes = [
        subprocess.Popen(
            [sys.executable, str(PROGRAM), str(folder), str(signal)],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(number)
    ]
    try:
        for process in processes:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
        signal.touch()
        got = []
        for process in processes:
            assert process.stdout is not None
            got.append((process, process.stdout.readline().split()))
        yield got
    finally:
        for process in processes:
            process.kill()
            process.communicate(timeout=PATIENCE_S)


def test_fifty_processes_get_fifty_slots(tmp_path: Path) -> None:
    """Started at once on a register that is not there yet: all slots differ, orders balance."""
    with reserving(tmp_path, 50) as got:
        assert sorted(int(slot) for _, (slot, _, _) in got) == list(range(1, 51))
        assert len({pseudonym for _, (_, pseudonym, _) in got}) == 50
        assert set(Counter(order for _, (_, _, order) in got).values()) == {25}
        with Register(tmp_path) as register:
            assert len(register.participants("race")) == 50
    assert (tmp_path / "participants.sqlite").stat().st_mode & 0o777 == 0o600


def test_a_killed_reservation_is_given_up(tmp_path: Path) -> None:
    """Its slot and order go to the next; one whose process lives is left alone."""
    with reserving(tmp_path, 2) as got:
        (first, (slot, pseudonym, order)), (_, (other, *_)) = got
        with Register(tmp_path) as register:
            assert register.reserve("race", ORDERS).slot == 3
            with pytest.raises(StudyError, match="is in a session: process"):
                register.reserve("race", ORDERS, pseudonym=pseudonym)
            first.kill()
            first.wait(PATIENCE_S)
            assert register.find("race", pseudonym) is not None
            again = register.reserve("race", ORDERS)
            assert (again.slot, ",".join(again.order)) == (int(slot), order)
            assert register.find("race", pseudonym) is None
            assert {each.slot for each in register.participants()} == {int(slot), int(other), 3}


@pytest.mark.skipif(sys.platform == "win32", reason="processes have no start time there")
def test_a_process_is_told_from_another_of_its_number() -> None:
    """A number given out again is not the process that held the lease; another machine: unknown."""
    me = this_process()
    assert is_alive(me) is True
    assert is_alive(ProcessIdentity(me.host, me.pid, "another boot/1")) is False
    assert is_alive(ProcessIdentity("elsewhere", me.pid, me.started)) is None
    ended = subprocess.Popen([sys.executable, "-c", ""])
    # Not waited for yet, it stays in the list of processes.
    started = ProcessIdentity(me.host, ended.pid, me.started)
    ended.wait(PATIENCE_S)
    assert is_alive(started) is False
