"""Time from recordings to the finished report, and how it grows with the number of sessions.

    python benchmarks/report_time.py [--sessions 12,25,50,100] [--minutes 30] [--keep FOLDER]

Sessions are made up and written by the product's own writer. Each number of sessions is reported
on in a process of its own, whose peak memory is read from the operating system. Growth is printed
as a ratio to the first number of sessions: 1.00 means exactly in proportion.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

TIMESTEPS_PER_SECOND = 8
FLEET_RUNS = 24
"""Fleet runs of a made-up session with people's part in it: 3, 3, 8 and 8, and 2 alone."""

REPORT = """
import resource, sys
from pathlib import Path
from analysis.commands.report import write_report
write_report([Path(p) for p in sys.argv[2:]], Path(sys.argv[1]))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", default="12,25,50,100")
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--keep", type=Path, default=None)
    given = parser.parse_args()
    counts = [int(part) for part in given.sessions.split(",")]
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.keep or Path(temporary) / "recordings"
        files = write_sessions(folder, max(counts), given.minutes)
        size = sum(path.stat().st_size for path in files[: counts[0]]) / 1e6
        print(f"{counts[0]} sessions of {given.minutes:g} minutes: {size:.0f} MB")
        print("sessions  seconds  growth  peak MB")
        first = 0.0
        for count in counts:
            seconds, peak = measure(files[:count], Path(temporary) / f"report{count}")
            first = first or seconds / counts[0]
            print(f"{count:8d} {seconds:8.1f} {seconds / count / first:7.2f} {peak:8.0f}")
    return 0


def write_sessions(folder: Path, count: int, minutes: float) -> list[Path]:
    """Write sessions that are not there yet; return all, in order."""
    from synthetic_study import study_plans, write_session  # noqa: PLC0415 - after the path

    folder.mkdir(parents=True, exist_ok=True)
    timesteps = round(minutes * 60 * TIMESTEPS_PER_SECOND / FLEET_RUNS)
    files = []
    for plan in study_plans(count, timesteps=timesteps):
        path = folder / f"session_{plan.index:02d}.mcap"
        files.append(path if path.exists() else write_session(folder, plan))
    return files


def measure(files: list[Path], output: Path) -> tuple[float, float]:
    """Report on files in a process of its own; return seconds and peak memory, MB."""
    command = [sys.executable, "-c", REPORT, str(output), *map(str, files)]
    start = time.perf_counter()
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - start
    if done.returncode:
        raise SystemExit(done.stderr)
    return seconds, float(done.stdout.split()[-1])


if __name__ == "__main__":
    sys.exit(main())
