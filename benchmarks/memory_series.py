"""Memory of a session's processes, second by second, and how it grows."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import os
import statistics
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

SETTLED_S = 600.0
SEEN_S = 240.0
FLOOR_S = 30.0
MEBIBYTE = 1 << 20


@dataclasses.dataclass(frozen=True)
class Sample:
    """Memory at one time.

    Attributes:
        at: seconds since the process was followed.
        taken: resident, MiB.
        place: what the session did.
    """

    at: float
    taken: float
    place: str


@dataclasses.dataclass(frozen=True)
class Growth:
    """How memory grew once it had settled.

    Attributes:
        last: MiB at the end.
        line: slope of the least-squares line through all of it, MiB an hour; None: too short.
        floor: median slope between the lowest values of any two half minutes of one phase, MiB an
            hour; None if no phase was long enough. What leaks raises the floor; what is
            taken for a moment does not. Of a phase the first four minutes are left out: by then
            all that it shows has been shown.
    """

    last: float
    line: float | None
    floor: float | None

    @property
    def sentence(self) -> str:
        """All of it in words."""
        line = "too short to say" if self.line is None else f"{self.line:+.2f} MiB an hour in all"
        floor = "" if self.floor is None else f", {self.floor:+.2f} within a phase"
        return f"{self.last:.0f} MiB at the end; {line}{floor}"


class MemorySeries:
    """Follows a study and the processes that it started.

    Attributes:
        place: what the session does now; whoever knows sets it.
    """

    def __init__(self) -> None:
        self.place = "start"
        self._samples: dict[str, list[Sample]] = {}

    @property
    def names(self) -> list[str]:
        """Names of the processes seen."""
        return sorted(self._samples)

    def follow(self, pid: int, stop: threading.Event) -> None:
        """Note the memory of all processes of a study once a second, until told to stop."""
        began = time.monotonic()
        while not stop.wait(1.0):
            for name, process in _processes(pid).items():
                with contextlib.suppress(OSError, IndexError):
                    taken = _resident(process)
                    # A process that has ended and was not yet waited for has none.
                    if taken:
                        sample = Sample(time.monotonic() - began, taken, self.place)
                        self._samples.setdefault(name, []).append(sample)

    def growth(self, name: str) -> Growth:
        """Return how a process grew."""
        rows = self._samples[name]
        after = min(SETTLED_S, rows[-1].at / 2)
        settled = [row for row in rows if row.at >= after]
        line = None
        if len(settled) >= 10:
            hours = np.array([row.at for row in settled]) / 3600
            line = float(np.polyfit(hours, [row.taken for row in settled], 1)[0])
        slopes = [slope for phase in _phases(rows, after) for slope in _slopes(phase)]
        return Growth(rows[-1].taken, line, statistics.median(slopes) if slopes else None)

    def write(self, path: Path) -> None:
        """Write all samples as a table."""
        lines = ["seconds,process,mebibytes,place\n"]
        for name, rows in self._samples.items():
            lines += [f"{row.at:.0f},{name},{row.taken:.2f},{row.place}\n" for row in rows]
        path.write_text("".join(lines), encoding="utf-8")


def _phases(rows: list[Sample], after: float) -> Iterator[list[Sample]]:
    """Yield the settled samples of each stretch in one place, but for its first minutes."""
    for _, group in itertools.groupby(rows, key=lambda row: row.place):
        stretch = list(group)
        begin = max(after, stretch[0].at + SEEN_S)
        yield [row for row in stretch if row.at >= begin]


def _slopes(rows: list[Sample]) -> list[float]:
    """Return the slopes between the lowest values of all pairs of half minutes, MiB an hour."""
    floors: dict[int, float] = {}
    for row in rows:
        number = int(row.at // FLOOR_S)
        floors[number] = min(row.taken, floors.get(number, row.taken))
    return [
        (floors[last] - floors[first]) / ((last - first) * FLOOR_S / 3600)
        for first, last in itertools.combinations(sorted(floors), 2)
    ]


def _processes(pid: int) -> dict[str, int]:
    """Return a session's processes by name."""
    found = {"study": pid}
    with contextlib.suppress(OSError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            command = Path(f"/proc/{child}/cmdline").read_bytes()
            name = "writer" if b"recording.writer" in command else "fitting"
            if b"resource_tracker" not in command:
                found[name] = int(child)
    return found


def _resident(pid: int) -> float:
    """Return a process's resident memory, MiB."""
    pages = Path(f"/proc/{pid}/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE") / MEBIBYTE
