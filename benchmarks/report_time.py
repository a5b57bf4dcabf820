"""Time from recordings to the finished report, and how it grows with the number of sessions.

    python -m benchmarks.report_time [--sessions 12,25,50,100] [--minutes 30] [--keep FOLDER]

Sessions are made up, with the fleet runs of a study with people, and written by the product's own
writer. Each number of sessions is reported on by a process of its own, from the start of Python to
the last table; its peak memory is the operating system's. Growth is seconds a session as a ratio
to the first number of sessions: 1.00 means exactly in proportion. Fails where the first number
takes longer than the target on two cores.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.made_up_sessions import machine
from benchmarks.made_up_studies import write_sessions

ROOT = Path(__file__).resolve().parents[1]

TARGET_S = 15.0
"""For twelve half-hour sessions."""

REPORT = """
import resource, sys
from pathlib import Path
from analysis.commands.report import write_report
write_report([Path(p) for p in sys.argv[2:]], Path(sys.argv[1]))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def main() -> int:
    """Measure and print; 1 if the target is missed."""
    parser = argparse.ArgumentParser(description="Seconds from recordings to a report.")
    parser.add_argument("--sessions", default="12,25,50,100", help="numbers of sessions")
    parser.add_argument("--minutes", type=float, default=30.0, help="length of a session")
    parser.add_argument("--keep", type=Path, help="folder in which the recordings stay")
    given = parser.parse_args()
    counts = [int(part) for part in given.sessions.split(",")]
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.keep or Path(temporary) / "recordings"
        files = write_sessions(folder, max(counts), given.minutes, "session")
        size = sum(path.stat().st_size for path in files[: counts[0]]) / 1e6
        print(machine())
        print(f"{counts[0]} sessions of {given.minutes:g} minutes: {size:.0f} MB")
        print("sessions  seconds  growth  peak MB")
        spent: dict[int, float] = {}
        for count in counts:
            seconds, peak = measure(files[:count], Path(temporary) / f"report{count}")
            spent[count] = seconds
            growth = seconds / count / (spent[counts[0]] / counts[0])
            print(f"{count:8d} {seconds:8.1f} {growth:7.2f} {peak:8.0f}", flush=True)
    allowed = TARGET_S * counts[0] / 12 * given.minutes / 30
    print(f"target for {counts[0]}: {allowed:.1f} s")
    return 1 if spent[counts[0]] > allowed else 0


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
