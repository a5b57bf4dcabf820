"""How long tests wait for what happens by itself; none of them is about the machine's speed."""

from __future__ import annotations

from typing import Final

PATIENCE_S: Final = 1200.0
"""Seconds after which something is taken not to come any more. Long, for a busy machine: only a
test that fails ever waits so long."""

PASS_S: Final = 0.02
"""What one pass of a watching loop counts for at most: in a longer one the loop was not let run."""
