"""Recordings of whole made-up studies, with the fleet runs of a study with people."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "support"))

from choosing_study import write_choosing
from synthetic_study import Plan, study_plans, write_session

TIMESTEPS_PER_SECOND = 8
FLEET_RUNS = 24
"""Fleet runs of a made-up session: three episodes, three of phase two, two blocks, two alone."""
WRITERS: dict[str, Callable[[Path, Plan], Path]] = {
    "session": write_session,
    "choosing": write_choosing,
}
"""By the beginning of the files' names: choices at random, or by scorers that are known."""


def write_sessions(folder: Path, count: int, minutes: float, kind: str) -> list[Path]:
    """Write sessions that are not there yet; return all, in order.

    Args:
        folder: where; made if need be.
        count: how many.
        minutes: length of each.
        kind: one of `WRITERS`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    timesteps = round(minutes * 60 * TIMESTEPS_PER_SECOND / FLEET_RUNS)
    files = []
    for plan in study_plans(count, timesteps=timesteps, planned=12):
        path = folder / f"{kind}_{plan.index:02d}.mcap"
        files.append(path if path.exists() else WRITERS[kind](folder, plan))
    return files
