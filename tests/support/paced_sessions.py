"""Sessions of twelve robots on the clock, one after another, each to be killed.

python paced_sessions.py PROTOCOL

For each line on standard input (``FOLDER SEED``) a session begins in a process of its own, whose
id is printed. It keeps a log, FOLDER/accepted.log: a line for what was handed over together, with
the number of the last record and, of each, topic and checksum. That log is written here, apart
from the recorder, so that a recording can be held against it. FOLDER/twelve_robots appears when
twelve robots begin to run.

The processes are forked from one that has loaded everything already, for the tests' speed alone;
it holds no pipe that a recording depends on.
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


def session(protocol: str, folder: Path, seed: int) -> None:
    """Run one session to its end, if it is let."""
    LoggedRecorder.log = os.open(folder / "accepted.log", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    PacedOperator.marker = folder / "twelve_robots"
    (assignment,) = simulating.simulated_assignments(load_protocol(protocol), 1, seed)
    simulating.simulate_session(protocol, assignment, seed, folder / "recordings", batch_bytes=0)


def say(line: str) -> None:
    """Tell whoever started this process."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main(protocol: str) -> None:
    """Serve one line after another."""
    simulating.SimulatedOperator = PacedOperator  # type: ignore[misc]
    composing.Recorder = LoggedRecorder  # type: ignore[misc]
    load_protocol(protocol)
    for line in sys.stdin:
        folder, seed = line.split()
        child = os.fork()
        if child == 0:
            os.close(0)
            session(protocol, Path(folder), int(seed))
            os._exit(0)
        say(str(child))
        os.waitpid(child, 0)
        say("ended")


if __name__ == "__main__":
    main(sys.argv[1])
