"""How punctual the participant's window is while twelve DOOM engines run behind it.

    python -m benchmarks.doom_window
    python -m benchmarks.doom_window --size 320x240

Runs protocols/doom.toml, shortened, by `study run` in a window of 1920x1080 on a virtual X server
(Xvfb), through which real keys press their way. Intervals between pictures, between timesteps and
between two looks at the keys are those that the session itself records of each fleet run. Pictures
of 60 a second show motion of 35 tics a second. The bare loop of `benchmarks/window_timing.py` says
what the machine allows.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
import tempfile
from pathlib import Path

from benchmarks.made_up_sessions import machine
from benchmarks.pressed_sessions import Played, fleet_runs, print_timing, run_one
from protocols import variant
from study.tasks._doom.parameters import FRAME_SIZES

SHORTER = (
    ("timesteps = 260", "timesteps = 60"),
    ("episodes = 10", "episodes = 3"),
    ("trials = 6", "trials = 1"),
    ("trials = 8\n", "trials = 1\n"),
    ("at_least = 16", "at_least = 2"),
)


def measure(size: str, place: Path) -> bool:
    """Run one session with pictures of a size and print its timing; return whether it ended."""
    folder = place / size
    folder.mkdir()
    protocol = variant(folder, *SHORTER, ('frame = "160x120"', f'frame = "{size}"'), base="doom")
    found = Played("P01", folder / "recordings")
    run_one(protocol, found, seed=1, display_size=(1920, 1080))
    print(f"\npictures of {size}:")
    if found.cause is not None or found.ended is None or not found.ended.complete:
        print(f"  did not reach its end: {found.cause or found.ended}")
        print((found.folder / "said").read_text()[-2000:])
        return False
    (path,) = found.folder.glob("*.mcap")
    for robots, timings in sorted(fleet_runs(path).items()):
        print(f" {robots} robots:")
        print_timing(timings)
    for name in found.memory.names:
        print(f" memory of {name} at the end: {found.memory.growth(name).last:.0f} MiB")
    return True


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--size", choices=FRAME_SIZES, action="append", help="of a picture")
    given = parser.parse_args()
    if importlib.util.find_spec("vizdoom") is None:
        print("vizdoom is not installed: pip install 'scaled-autonomy[doom]'")
        return 1
    print(machine())
    sizes = given.size or ["160x120", "320x240"]
    with tempfile.TemporaryDirectory(prefix="sa") as place:
        # Other sessions of this computer are none of ours.
        os.environ |= {"XDG_RUNTIME_DIR": place, "TMPDIR": place}
        tempfile.tempdir = place
        well = sum(measure(size, Path(place)) for size in sizes) == len(sizes)
    print(f"\nLoad of the machine during the last minute: {os.getloadavg()[0]:.1f}.")
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main())
