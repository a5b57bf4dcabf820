"""How long tests wait for what happens by itself; none of them is about the machine's speed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

PATIENCE_S: Final = 1200.0
"""Seconds after which something is taken not to come any more. Long, for a busy machine: only a
test that fails ever waits so long."""

PASS_S: Final = 0.02
"""What one pass of a watching loop counts for at most: in a longer one the loop was not let run."""


def until(reached: Callable[[], bool], look_s: float = 0.05) -> None:
    """Wait until something holds, looking so often."""
    end = time.monotonic() + PATIENCE_S
    while not reached():
        assert time.monotonic() < end, "not reached in time"
        time.sleep(look_s)
