"""A session of twelve robots on the clock, to be killed.

python paced_session.py PROTOCOL FOLDER SEED

It keeps a log, FOLDER/accepted.log: a line for what was handed over together, with the number of
the last record and, of each, topic and checksum. That log is written here, apart from the recorder,
so that a recording can be held against it. FOLDER/twelve_robots appears when twelve robots begin to
run.
"""

from __future__ import annotations

import os
import sys
import time
import zlib
from collections.abc import Sequence
from pathlib import Path

from study.commands import composing, simulating
from study.events.fields import Record
from study.loading import load_protocol
from study.recording.client import Recorder
from study.recording.wire import encode
from study.screens import FleetScreen, Screen
from study.simulated.keys import KeyStroke
from study.simulated.operator import SimulatedOperator

TIMESTEPS_PER_SECOND = 35
ROBOTS = 12


class LoggedRecorder(Recorder):
    """A recorder that notes in a log what it has accepted."""

    log = -1

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Hand records over, then note them."""
        last = super().write_together(records)
        noted = " ".join(f"{record.topic}:{zlib.crc32(encode(record))}" for record, _ in records)
        os.write(LoggedRecorder.log, f"{last} {noted}\n".encode())
        return last


class PacedOperator(SimulatedOperator):
    """Acts at the rate of a person's session once twelve robots are shown."""

    marker = Path()
    due = 0.0

    def act(self, screen: Screen, now_ns: int) -> tuple[KeyStroke, ...]:
        """Wait for the timestep, then act."""
        if isinstance(screen, FleetScreen) and screen.robots == ROBOTS:
            PacedOperator.marker.touch()
            now = time.perf_counter()
            time.sleep(max(0.0, self.due - now))
            self.due = max(self.due, now) + 1 / TIMESTEPS_PER_SECOND
        return super().act(screen, now_ns)


def main(protocol: str, folder: Path, seed: int) -> None:
    """Run one session to its end, if it is let."""
    simulating.SimulatedOperator = PacedOperator  # type: ignore[attr-defined]
    composing.Recorder = LoggedRecorder  # type: ignore[attr-defined]
    PacedOperator.marker = folder / "twelve_robots"
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
    LoggedRecorder.log = os.open(folder / "accepted.log", flags, 0o600)
    (assignment,) = simulating.simulated_assignments(load_protocol(protocol), 1, seed)
    simulating.simulate_session(protocol, assignment, seed, folder / "recordings", batch_bytes=0)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))
