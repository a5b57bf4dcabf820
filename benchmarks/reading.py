"""How fast recordings are read, against mcap's own reader with JSON and against bare unpacking.

python -m benchmarks.reading [--quick]

A half-hour session of twelve robots at 35 timesteps a second is read into a DataFrame of one row a
robot and timestep. The alternatives read the same session: mcap's reader from a file of JSON
objects, and a loop that only unpacks, checks and maps the bytes of our own file: the limit.
All take turns in one run. Our files have a chunk for each half second, as a session writes them.
"""

from __future__ import annotations

import json
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import zstandard
from mcap.reader import make_reader

from benchmarks.made_up_sessions import HALF_HOUR, ROBOT_FIELDS, machine, write_json, write_ours
from study.recording.reader import read_recording

STATES = ("x", "y", "heading", "health")
TOPIC = "event/timestep"


def frame_of(path: Path) -> pd.DataFrame:
    """Read one of our recordings into a DataFrame."""
    frames = []
    for run in read_recording(path).columns(TOPIC):
        rows, robots = run["actions"].shape
        columns = {"timestep": np.repeat(np.arange(rows, dtype=np.int32), robots)}
        columns["robot"] = np.tile(np.arange(robots, dtype=np.int32), rows)
        columns |= {name: run["states"][:, :, place].ravel() for place, name in enumerate(STATES)}
        columns |= {name: run[name].ravel() for name in ROBOT_FIELDS}
        frames.append(pd.DataFrame(columns, copy=False))
    return frames[0] if len(frames) == 1 else pd.concat(frames, ignore_index=True)


def frame_of_json(path: Path) -> pd.DataFrame:
    """Read the JSON file with mcap's reader into the same DataFrame."""
    rows = []
    with path.open("rb") as stream:
        for number, (_, _, message) in enumerate(make_reader(stream).iter_messages()):
            for robot, values in enumerate(json.loads(message.data)["robots"]):
                rows.append({"timestep": number, "robot": robot, **values})
    return pd.DataFrame(rows)


def only_unpack(path: Path, chunks: Sequence[tuple[int, int]]) -> int:
    """Read, unpack, check and map each chunk; return the bytes."""
    unpacker = zstandard.ZstdDecompressor()
    total = 0
    with path.open("rb") as stream:
        for start, length in chunks:
            stream.seek(start)
            payload = stream.read(length)
            checksum, name = struct.unpack_from("<II", payload, 24)
            data = unpacker.decompress(memoryview(payload)[32 + name + 8 :])
            assert zlib.crc32(data) == checksum
            total += np.frombuffer(data, np.uint8).size
    return total


def seconds(work: Callable[[], object], times: int) -> tuple[float, float]:
    """Return the least and the median time of some runs, s."""
    taken = []
    for _ in range(times):
        begun = time.perf_counter()
        work()
        taken.append(time.perf_counter() - begun)
    return min(taken), float(np.median(taken))


def one_session(folder: Path, timesteps: int, times: int) -> Path:
    """Print the times for one session."""
    ours = write_ours(folder, "ours", 12, timesteps)
    naive = write_json(folder / "naive.mcap", 12, timesteps)
    assert frame_of(ours)[list(STATES)].equals(
        frame_of_json(naive)[list(STATES)].astype(np.float32)
    )
    table = read_recording(ours).chunks
    chunks = list(zip(table.start.tolist(), table.length.tolist(), strict=True))
    measured = {
        "ours": seconds(lambda: frame_of(ours), times),
        "unpacking only": seconds(lambda: only_unpack(ours, chunks), times),
        "mcap's reader and JSON": seconds(lambda: frame_of_json(naive), max(1, times // 5)),
    }
    least, median = measured["ours"]
    for name, (low, middle) in measured.items():
        print(
            f"  {name:24s} {low:8.3f} s (median {middle:.3f})   "
            f"{low / least:7.2f} times ours (medians {middle / median:.2f})"
        )
    return ours


def growth(paths: Sequence[Path], sessions: int) -> None:
    """Print time and memory of reading sessions one after another, in a fresh process."""
    code = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from benchmarks import reading\n"
        "begun = time.perf_counter()\n"
        "rows = sum(len(reading.frame_of(Path(p))) for p in sys.argv[1:])\n"
        "print(time.perf_counter() - begun, rows, reading.peak_mib())\n"
    )
    given = [str(paths[number % len(paths)]) for number in range(sessions)]
    done = subprocess.run(
        [sys.executable, "-c", code, *given], capture_output=True, text=True, check=True
    )
    taken, rows, mib = done.stdout.split()
    print(f"  {sessions:4d} sessions   {float(taken):7.2f} s   {int(rows):,} rows   peak {mib} MiB")


def peak_mib() -> int:
    """Return the most memory that this process has held, MiB.

    Not that of `getrusage`, which counts what the parent held when it forked.
    """
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) // 1024 for line in lines if line.startswith("VmHWM"))


def main() -> None:
    """Measure and print."""
    quick = "--quick" in sys.argv
    timesteps = HALF_HOUR // 20 if quick else HALF_HOUR
    print(machine())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print(f"One session of 12 robots, {timesteps:,} timesteps, to a DataFrame:")
        one_session(folder, timesteps, 5 if quick else 15)
        print("Several, one after another:")
        paths = [write_ours(folder, f"s{number}", 12, timesteps, number) for number in range(10)]
        for sessions in (1, 10, 12, 100):
            growth(paths, sessions)


if __name__ == "__main__":
    main()
