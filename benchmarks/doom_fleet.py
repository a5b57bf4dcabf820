"""Fleet steps a second of the DOOM task: engines in workers against one process, in turn.

python -m benchmarks.doom_fleet [--quick]

The alternative is the plain loop: one process that steps all engines one after the other and
copies their pictures. Both are given the same starts and actions, and every pose must agree to
the last bit. A fleet step steps all n robots for one timestep: four tics, each of them drawn; the
second row of a size draws the last tic only. The two take turns, block by block, so that what
else the machine does meets both: the ratio is that of the medians, "undisturbed" that of the
least times.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.growth import versions
from benchmarks.made_up_sessions import machine
from study.layouts import named_layout
from study.seeding import generator
from study.tasks import doom
from study.tasks._doom.coding import to_commands, to_poses
from study.tasks._doom.conventions import TICS
from study.tasks._doom.crew import Crew, Numbers
from study.tasks._doom.engine import Command, Engine, Pose, write_launcher
from study.tasks._doom.plane import on_grid
from study.tasks._doom.wad import Motion, write_wad

ROBOTS = 12
TARGET = 1.8
CHANCES = (0.5, 0.1, 0.15, 0.15, 0.1)
BLOCK = 16
"""Fleet steps measured in a row."""

LAYOUT = named_layout("three_rooms")
WAD = write_wad(LAYOUT, Motion(0.5, 0.3, stock=False, damage=5.0, heal=10.0))
START = (on_grid(LAYOUT.start_mark.x), on_grid(LAYOUT.start_mark.y))
EVERY = np.ones(ROBOTS, np.bool_)


class InTurn:
    """Twelve engines in this process, stepped one after the other."""

    def __init__(self, height: int, width: int, *, every_tic: bool) -> None:
        self._scratch = Path(tempfile.mkdtemp(prefix="doom_benchmark_"))
        wad = self._scratch / "map.wad"
        wad.write_bytes(WAD)
        self._every_tic = every_tic
        launcher = write_launcher(self._scratch)
        with contextlib.chdir(self._scratch):
            self._engines = [Engine(wad, launcher, width, height, START) for _ in range(ROBOTS)]
        self._frames = np.zeros((ROBOTS, TICS, height, width, 3), np.uint8)

    def place(self, poses: Numbers) -> None:
        """Put every robot somewhere."""
        for engine, pose in zip(self._engines, poses.tolist(), strict=True):
            engine.place(Pose(*pose))

    def step(self, commands: Numbers) -> list[Pose]:
        """Take one timestep with every robot."""
        poses = []
        for robot, engine in enumerate(self._engines):
            forward, backward, turn = commands[robot].tolist()
            command = Command(bool(forward), bool(backward), turn)
            poses.append(engine.step(command, self._frames[robot] if self._every_tic else None))
            if not self._every_tic:
                engine.copy_frame(self._frames[robot, -1])
        return poses

    def close(self) -> None:
        """End the engines."""
        for engine in self._engines:
            engine.close()
        shutil.rmtree(self._scratch, ignore_errors=True)


def below(pid: int) -> list[int]:
    """Return the ids of all processes below one."""
    found = []
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, listed.read_text().split()):
            found += [child, *below(child)]
    return found


def megabytes(pids: list[int]) -> float:
    """Return the memory of processes, MB; what they share is divided among its users."""
    total = 0
    for pid in pids:
        with contextlib.suppress(OSError):
            for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    total += int(line.split()[1])
    return total / 1024


def commands_of(timesteps: int) -> list[Numbers]:
    """Return made-up commands, the same for both."""
    random = generator(1, "doom_benchmark")
    turn = np.radians([0.0, 0.0, 15.0, -15.0, 0.0])
    heading: npt.NDArray[np.float64] = np.zeros(ROBOTS)
    commands = []
    for _ in range(timesteps):
        actions = random.choice(5, ROBOTS, p=CHANCES).astype(np.int32)
        commands.append(to_commands(actions, heading, heading + turn[actions]))
        heading = heading + turn[actions]
    return commands


def measure(size: str, blocks: int, *, every_tic: bool) -> float:
    """Measure one size; print it and return how many times as fast the workers are."""
    settings = doom.Parameters.model_validate({"frame": size})
    height, width = settings.frame_shape
    starts = to_poses(doom.spread_states(settings, generator(1, "doom_starts"), ROBOTS))
    starts[:, 2] = 0
    begun = time.perf_counter()
    crew = Crew(
        ROBOTS, WAD, START, (height, width), every_tic=every_tic, workers=settings.workers,
        patience=10.0,
    )  # fmt: skip
    start_up = time.perf_counter() - begun
    crew.place(EVERY, starts)
    memory = megabytes([*crew.pids(), *(pid for worker in crew.pids() for pid in below(worker))])
    alone = InTurn(height, width, every_tic=every_tic)
    alone.place(starts)
    ours, theirs = [], []
    for block in range(blocks + 1):
        commands = commands_of((blocks + 1) * BLOCK)[block * BLOCK : (block + 1) * BLOCK]
        begun = time.perf_counter()
        for command in commands:
            poses = crew.step(EVERY, command)
        between = time.perf_counter()
        for command in commands:
            others = alone.step(command)
        done = time.perf_counter()
        assert [Pose(*pose) for pose in poses.tolist()] == others
        if block:  # the first one warms up
            ours.append((between - begun) / BLOCK)
            theirs.append((done - between) / BLOCK)
    crew.close()
    alone.close()
    mine, their = float(np.median(ours)), float(np.median(theirs))
    least = min(theirs) / min(ours)
    drawn = "every tic drawn" if every_tic else "last tic drawn"
    print(
        f"  {size}, {drawn}: {1 / mine:.0f} fleet steps/s in {settings.workers} workers, "
        f"{1 / their:.0f} in turn ({their / mine:.2f}x; "
        f"undisturbed {least:.2f}x); start-up {start_up:.1f} s, "
        f"{memory / ROBOTS:.1f} MB a robot",
        flush=True,
    )
    return their / mine


def main() -> None:
    """Measure and print."""
    if importlib.util.find_spec("vizdoom") is None:
        print("vizdoom is not installed: pip install 'scaled-autonomy[doom]'")
        sys.exit(1)
    blocks = 10 if "--quick" in sys.argv else 40
    print(machine())
    print(versions("numpy", "vizdoom"))
    print(
        f"{ROBOTS} robots, a step of {TICS} tics, equal to the last bit; people need 8.75 a second:"
    )
    ratios = {
        (size, every_tic): measure(size, blocks, every_tic=every_tic)
        for size in ("160x120", "320x240")
        for every_tic in (True, False)
    }
    ratio = ratios["160x120", True]
    word = "reached" if ratio >= TARGET else "not reached"
    load = os.getloadavg()[0]
    print(
        f"At 160x120 the workers are {ratio:.2f} times as fast; the target of {TARGET} is {word}."
    )
    print(f"Load of the machine during the last minute: {load:.1f}.")


if __name__ == "__main__":
    main()
