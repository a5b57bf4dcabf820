"""A simulated session that sends each record at once, as a person's does: to be killed."""

from __future__ import annotations

import sys
from pathlib import Path

from study.commands.simulating import simulate_session, simulated_assignments
from study.loading import load_protocol

if __name__ == "__main__":
    protocol, folder = sys.argv[1:]
    (assignment,) = simulated_assignments(load_protocol(protocol), 1, seed=5)
    simulate_session(protocol, assignment, 5, Path(folder), batch_bytes=0)
