"""What recording costs the study at each timestep, against naive JSON and mcap's own writer.

python -m benchmarks.writing [--quick]

Ours and the alternative take turns in one run, on the same records. The processor time of ours is
that of the study's process, its sending thread included; the writer process, which runs beside it,
is printed apart. The time that a timestep stands still is wall time of the call with the disk being
synced every half second, beside the same loop without the call.
"""

from __future__ import annotations

import io
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.made_up_sessions import RATE, START_NS, as_json, json_writer, machine, timesteps
from study.recording.client import Recorder

TURNS = 20


def process_seconds(pid: int) -> float:
    """Return the processor time that a process has used, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100


def cost(robots: int, count: int, folder: Path) -> float:
    """Print the processor time of one timestep, ours and naive; return ours, s."""
    records = list(timesteps(robots, count))
    recorder = Recorder.start(folder, f"cost_{robots}", {}, {})
    writer, channel = json_writer(io.BytesIO())
    ours: list[float] = []
    naive: list[float] = []
    started = process_seconds(recorder.writer_pid)
    for _ in range(TURNS):
        begun = time.process_time()
        for record in records:
            recorder.write(record, START_NS + record.t_ns)
        ours.append((time.process_time() - begun) / count)
        recorder.ensure_durable(30)
        begun = time.process_time()
        for record in records:
            time_ns = START_NS + record.t_ns
            writer.add_message(channel, time_ns, as_json(record), time_ns)
        naive.append((time.process_time() - begun) / count)
    beside = (process_seconds(recorder.writer_pid) - started) / (TURNS * count)
    recorder.close()
    best_ours, best_naive = min(ours), min(naive)
    print(
        f"n={robots:5d}  ours {best_ours * 1e6:8.1f} us   JSON {best_naive * 1e6:8.1f} us   "
        f"ratio {best_naive / best_ours:6.1f}   (medians: ratio "
        f"{np.median(naive) / np.median(ours):.1f}; writer process {beside * 1e6:.0f} us)"
    )
    return best_ours


def plain(rounds: int) -> None:
    """Do some work that is not recording: small objects made and thrown away."""
    for number in range(rounds):
        {str(number): [number, number * 2]}


def rounds_of(seconds: float) -> int:
    """Return for how many rounds `plain` takes that long in a loop that never sleeps."""
    begun = time.perf_counter()
    plain(100_000)
    return max(1, round(100_000 * seconds / (time.perf_counter() - begun)))


def stall(robots: int, seconds: float, folder: Path, busy_s: float) -> None:
    """Print how long the call stands still at the rate of a session, and a loop without it.

    As in a session, each record is made the moment before it is written. A processor that was
    asleep does anything more slowly at first; how much shows in plain Python of as much work,
    ``busy_s`` seconds of it where nothing sleeps, at the same place of the same loop.
    """
    rounds = rounds_of(busy_s)
    count = int(seconds * RATE)
    records = timesteps(robots, count)
    recorder = Recorder.start(folder, f"stall_{robots}", {}, {})
    durations: dict[str, list[float]] = {"ours": [], "plain": [], "bare": []}
    due = time.perf_counter()
    for number in range(count):
        due += 1 / RATE
        time.sleep(max(0.0, due - time.perf_counter()))
        record = next(records)
        begun = time.perf_counter()
        durations["bare"].append(time.perf_counter() - begun)
        # In turn, so that neither finds the processor warmed by the other.
        begun = time.perf_counter()
        if number % 2:
            plain(rounds)
            durations["plain"].append(time.perf_counter() - begun)
            recorder.write(record, START_NS + record.t_ns)
        else:
            recorder.write(record, START_NS + record.t_ns)
            durations["ours"].append(time.perf_counter() - begun)
    recorder.close()
    for name, values in durations.items():
        p50, p99, most = np.percentile(values, [50, 99, 100]) * 1e3
        print(
            f"n={robots:5d}  {name:5s}  median {p50:.4f} ms   p99 {p99:.4f} ms   "
            f"longest {most:.3f} ms"
        )


def main() -> None:
    """Measure and print."""
    quick = "--quick" in sys.argv
    print(machine())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print("Processor time of one timestep:")
        busy = {
            12: cost(12, 200 if quick else 1000, folder),
            1000: cost(1000, 10 if quick else 50, folder),
        }
        print("Standing still, disk synced every half second:")
        for robots, busy_s in busy.items():
            stall(robots, 3 if quick else 40, folder, busy_s)


if __name__ == "__main__":
    main()
