"""A plan on a Dask cluster: the same as on one core."""

from __future__ import annotations

from pathlib import Path

import pytest

from command_line import study
from dask_cluster import count_workers, dask_process, free_port
from patience import until

pytest.importorskip("distributed", reason="needs the extra cluster")
PLAN = ("plan", "smoke", "--effect", "20", "--effect-sd", "15", "--trial-sd", "30")
SIZES = ("--participants", "6,12", "--trials", "4", "--studies", "3000")


def test_a_cluster_plans_as_one_core_does(tmp_path: Path) -> None:
    """Report and tables are the same to the byte."""
    address = f"tcp://127.0.0.1:{free_port()}"
    port = address.rpartition(":")[2]
    scheduler = ("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
    worker = ("worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
    with (
        dask_process(*scheduler, folder=tmp_path),
        dask_process(*worker, folder=tmp_path),
    ):
        until(lambda: count_workers(address) == 1)
        there = study(*PLAN, *SIZES, "--scheduler", address, "-o", tmp_path / "there")
    assert there.returncode == 0, there.stderr
    here = study(*PLAN, *SIZES, "--jobs", "1", "-o", tmp_path / "here")
    assert here.returncode == 0, here.stderr
    for name in ("report.html", "tables/power.csv", "tables/otherwise.csv"):
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


def test_no_scheduler_is_one_message(tmp_path: Path) -> None:
    """An address where nobody answers is said so, and nothing is written."""
    address = f"tcp://127.0.0.1:{free_port()}"
    done = study(*PLAN, *SIZES, "--scheduler", address, "-o", tmp_path / "x")
    assert done.returncode == 2
    assert "no Dask scheduler answers" in done.stderr
    assert not (tmp_path / "x").exists()
