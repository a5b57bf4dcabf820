"""Checks of the computer that need no window: disk, clocks."""

from __future__ import annotations

import contextlib
import os
import shutil
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from study.preflight_result import Check, Limits

TIMES_NEEDED = 3
"""How many times what a session writes should be free."""
SYNCS = 40
SYNC_BYTES = 4096
SYNC_P95_S = Limits(amber=0.1, red=1.0)
"""A participant waits for the disk after each answer; a stall of a second begins a new part."""
CLOCK_S = 2.0
CLOCK_DRIFT_S = Limits(amber=0.005, red=0.1)
EARLIEST = datetime(2025, 1, 1, tzinfo=UTC)
MEBIBYTE = 1 << 20


def existing(folder: Path) -> Path:
    """Return the folder, or the nearest one above it that exists."""
    return next(
        place for place in (folder.absolute(), *folder.absolute().parents) if place.is_dir()
    )


def free_bytes(folder: Path) -> int:
    """Return how much can still be written in a folder, which need not exist yet."""
    return shutil.disk_usage(existing(folder)).free


def disk_space(folder: Path, needed: int) -> Check:
    """Check that a session fits on the disk several times.

    Args:
        folder: of the recordings; need not exist yet.
        needed: what one session writes at most, bytes.
    """
    free = free_bytes(folder)
    enough = free >= TIMES_NEEDED * needed
    return Check(
        name="disk space",
        state="green" if enough else "red",
        found=f"{free / MEBIBYTE:,.0f} MiB free in {folder}",
        wanted=f"{TIMES_NEEDED} times the {needed / MEBIBYTE:,.0f} MiB of a session",
        advice="" if enough else "Free some space, or record elsewhere with -o.",
    )


def write_latency(folder: Path) -> Check:
    """Check how long it takes until something written is on the disk."""
    wanted = f"19 of 20 within {SYNC_P95_S.amber * 1e3:.0f} ms"
    path = existing(folder) / f".preflight-{os.getpid()}"
    sync = getattr(os, "fdatasync", os.fsync)
    took = []
    try:
        descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
        try:
            for _ in range(SYNCS):
                began = time.perf_counter()
                os.write(descriptor, bytes(SYNC_BYTES))
                sync(descriptor)
                took.append(time.perf_counter() - began)
        finally:
            os.close(descriptor)
    except OSError as error:
        return Check(
            name="writing",
            state="red",
            found=f"{folder}: {error.strerror}",
            wanted=wanted,
            advice="Record in a folder that can be written to, with -o.",
        )
    finally:
        with contextlib.suppress(OSError):
            path.unlink()
    high, longest = np.quantile(took, 0.95), max(took)
    state = SYNC_P95_S.state(float(high))
    return Check(
        name="writing",
        state=state,
        found=f"on disk after {np.median(took) * 1e3:.1f} ms, 19 of 20 within {high * 1e3:.1f} ms, "
        f"at most {longest * 1e3:.0f} ms",
        wanted=wanted,
        advice="" if state == "green" else "Record on a local disk that nothing else writes to.",
    )


class Clocks:
    """Compares the two clocks of the computer from its making to `check`."""

    def __init__(self) -> None:
        self._began = (time.perf_counter(), time.time())

    def check(self) -> Check:
        """Check that wall time is plausible and went on as steadily as monotonic time.

        Waits until `CLOCK_S` have passed in all.
        """
        monotonic, wall = self._began
        time.sleep(max(0.0, CLOCK_S - (time.perf_counter() - monotonic)))
        passed = time.perf_counter() - monotonic
        apart = abs((time.time() - wall) - passed)
        now = datetime.now(UTC)
        state = "red" if now < EARLIEST else CLOCK_DRIFT_S.state(apart)
        return Check(
            name="clock",
            state=state,
            found=f"{now:%Y-%m-%d %H:%M:%S} UTC; the clocks differ by {apart * 1e3:.2f} ms "
            f"after {passed:.0f} s",
            wanted=f"the right time, going on within {CLOCK_DRIFT_S.amber * 1e3:.0f} ms",
            advice="" if state == "green" else "Set the clock, and let it be synchronised (NTP).",
        )
