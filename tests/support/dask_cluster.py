"""A Dask scheduler and workers as programs of their own."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from protocols import ROOT

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


@contextlib.contextmanager
def dask_process(*arguments: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
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


def free_port() -> int:
    """Return a port that nobody listens at."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def count_workers(address: str) -> int:
    """Return how many workers a scheduler has; 0 while it does not answer."""
    import distributed

    cluster: Any = distributed

    with (
        contextlib.suppress(OSError, TimeoutError),
        cluster.Client(address, timeout="2s", set_as_default=False) as client,
    ):
        return len(client.scheduler_info(n_workers=-1)["workers"])
    return 0
