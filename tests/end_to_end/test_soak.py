"""The soak in its short form; the full one is `python -m benchmarks.soak`."""

from __future__ import annotations

import subprocess
import sys

import pytest

from patience import PATIENCE_S
from protocols import ROOT

pytestmark = [
    pytest.mark.acceptance,
    pytest.mark.skipif(sys.platform != "linux", reason="a private X server, memory by /proc"),
]


def test_three_participants_at_real_speed_lose_nothing() -> None:
    """At once and beside a CPU hog: each reaches the end, nothing accepted lacks, all replays."""
    command = [sys.executable, "-m", "benchmarks.soak", "--minutes", "2", "--together"]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(" 0 lost") == 3
    assert done.stdout.count("replay: identical") == 3
    assert done.stdout.count("memory of study:") == 3
