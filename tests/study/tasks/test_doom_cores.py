"""Which core the workers of a fleet in DOOM keep to."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from study.tasks._doom import cores

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="cores can be chosen on Linux")


@pytest.fixture
def eight(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[int]:
    """Eight cores, of which 0 and 4, 1 and 5, 2 and 6, 3 and 7 share their units."""
    for core in range(8):
        topology = tmp_path / f"cpu{core}" / "topology"
        topology.mkdir(parents=True)
        (topology / "thread_siblings_list").write_text(f"{core % 4},{core % 4 + 4}\n")
    monkeypatch.setattr(cores, "_TOPOLOGY", tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))
    return list(range(8))


def test_workers_of_a_fleet_share_no_core(eight: list[int]) -> None:
    """Whatever the number of the process, each worker has its own; many at once spread out."""
    for number in range(40):
        for workers in (1, 2, 3, 8):
            found = cores.cores_of(workers, number)
            assert len(set(found)) == workers
            assert set(found) <= set(eight)
    four = {core for number in range(4) for core in cores.cores_of(2, number)}
    assert four == set(eight)


@pytest.mark.usefixtures("eight")
def test_two_workers_do_not_share_the_units_of_a_core() -> None:
    """Of hyper-threads of one core the second is taken when all others have one."""
    for number in range(40):
        first, second = cores.cores_of(2, number)
        assert first is not None
        assert second is not None
        assert first % 4 != second % 4


@pytest.mark.usefixtures("eight")
def test_more_workers_than_cores_are_left_to_the_kernel() -> None:
    """None of them is told where to run."""
    assert cores.cores_of(9, 1) == [None] * 9


def test_ranges_of_siblings_are_understood(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As some kernels list them: 0-1 shares, 2-3 shares."""
    for core in range(4):
        topology = tmp_path / f"cpu{core}" / "topology"
        topology.mkdir(parents=True)
        (topology / "thread_siblings_list").write_text("0-1" if core < 2 else "2-3")
    monkeypatch.setattr(cores, "_TOPOLOGY", tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2, 3})
    assert sorted(map(str, cores.cores_of(2, 0))) == ["0", "2"]


def test_a_process_and_what_it_starts_keep_to_a_core() -> None:
    """Both say so themselves."""
    core = max(os.sched_getaffinity(0))
    say = "import os; print(sorted(os.sched_getaffinity(0)), flush=True)"
    program = (
        "import subprocess, sys\n"
        "from study.tasks._doom.cores import keep_to\n"
        f"keep_to(None)\nkeep_to({core})\n{say}\n"
        f"subprocess.run([sys.executable, '-c', {say!r}], check=True)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.split("\n")[:2] == [f"[{core}]"] * 2
