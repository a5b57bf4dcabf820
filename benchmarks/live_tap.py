"""What a live view costs a tick: handing one timestep's records on, with and without it.

    python -m benchmarks.live_tap [TICKS]

Both are measured in one run, in turns, against the same writer process; the times are CPU time of
this process, the stalls wall time.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.made_up_sessions import machine, timesteps
from study.events.fields import Record
from study.events.inputs import FleetObserved, TimestepDue
from study.foxglove.live_tap import LiveTap
from study.recording.client import Recorder
from study.recording.tapped import TappedRecorder

ROUNDS = 10


def records_of_a_tick(robots: int) -> list[Record]:
    """Return what one timestep of n robots records."""
    (step,) = timesteps(robots, 1)
    seen = (step.states, step.rewards, step.outcomes, step.actions, step.scores)
    return [TimestepDue(1, 0), step, FleetObserved(1, 0, robots, *seen)]


def measure(recorder: Recorder | TappedRecorder, records: list[Record], ticks: int) -> np.ndarray:
    """Return CPU and wall time of each tick, seconds, [ticks, 2]."""
    times = np.empty((ticks, 2))
    for tick in range(ticks):
        now = time.time_ns()
        cpu, wall = time.process_time(), time.perf_counter()
        for record in records:
            recorder.write(record, now)
        times[tick] = time.process_time() - cpu, time.perf_counter() - wall
        time.sleep(0.002)
    return times


def main(arguments: list[str]) -> None:
    """Print a line for each fleet size."""
    print(machine())
    ticks = int(arguments[0]) if arguments else 200
    for robots in (12, 1000):
        records = records_of_a_tick(robots)
        with tempfile.TemporaryDirectory() as folder:
            recorder = Recorder.start(Path(folder), "bench", {}, {})
            tap = LiveTap.start("127.0.0.1", 0)
            tapped = TappedRecorder(recorder, tap)
            plain, seen = [], []
            for _ in range(ROUNDS):
                plain.append(measure(recorder, records, ticks // ROUNDS))
                seen.append(measure(tapped, records, ticks // ROUNDS))
            tap.close()
            recorder.close()
        without, with_it = np.concatenate(plain), np.concatenate(seen)
        cpu, cpu_live = np.median(without[:, 0]) * 1e6, np.median(with_it[:, 0]) * 1e6
        wall, wall_live = np.quantile(without[:, 1], 0.99), np.quantile(with_it[:, 1], 0.99)
        print(
            f"n={robots}: {cpu:.0f} us CPU a tick without, {cpu_live:.0f} us with a live view: "
            f"{cpu_live / cpu:.2f} times; p99 stall {wall * 1e3:.2f} and {wall_live * 1e3:.2f} ms; "
            f"{tap.dropped} records dropped"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
