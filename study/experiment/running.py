"""Trials on all cores or on a cluster, each written as it comes; what is there is not run again.

Workers compute and one process writes, so that results do not depend on who computed them, on
how many there were or in which order they finished.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from study.errors import StudyError
from study.experiment.protocol import LoadedExperiment, SeedSet
from study.simulated.trained_user import WEIGHTS
from study.trial_files import (
    Head,
    Tables,
    file_name,
    read_trial,
    trial_paths,
    write_head,
    write_trial,
)
from study.workers import run_pieces

PACKAGES = ("scaled-autonomy", "numpy", "scipy", "torch", "safetensors")

_one_at_a_time = threading.Lock()
"""torch's seeds belong to a process: two trials in threads of one would disturb each other."""

Finished = tuple[int, Tables, float]


def versions(task: str) -> dict[str, str]:
    """Return the versions of what computes results, by name; of the task's user its hash."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    user = WEIGHTS / f"{task}.safetensors"
    if user.is_file():
        found["trained user"] = hashlib.sha256(user.read_bytes()).hexdigest()[:16]
    return found


def missing_trials(
    loaded: LoadedExperiment, seeds: SeedSet, trials: int, folder: Path
) -> list[int]:
    """Open a folder for results and return the trials that are still to be run.

    Files that are damaged, or were computed with other versions, count as missing.

    Raises:
        StudyError: the folder is not for these results.
    """
    head = Head(loaded.text, loaded.sha256, seeds, versions(loaded.protocol.task.name))
    write_head(folder, head)
    done = set()
    for path in trial_paths(folder):
        try:
            found = read_trial(path, loaded.sha256)
        except StudyError:
            continue
        if found.versions == head.versions:
            done.add(path.name)
    return [trial for trial in range(trials) if file_name(trial) not in done]


def run_trials(
    loaded: LoadedExperiment,
    seeds: SeedSet,
    trials: Sequence[int],
    folder: Path,
    *,
    jobs: int = -1,
    scheduler: str = "",
) -> Iterator[int]:
    """Run trials and write their files; yield each one's number when it is on disk.

    Args:
        loaded: the experiment.
        seeds: which set of worlds.
        trials: their numbers.
        folder: opened by `missing_trials`.
        jobs: processes at once on this machine; -1 for one a core.
        scheduler: address of a Dask cluster's scheduler to use instead.

    Raises:
        StudyError: a worker was ended from outside, or the cluster cannot be used.
    """
    if not trials:
        return
    finished = run_pieces(
        timed_trial,
        [(loaded.text, seeds, trial) for trial in trials],
        jobs=jobs,
        scheduler=scheduler,
        what="trial",
        again="Run the command again: finished trials are kept.",
    )
    made_with = versions(loaded.protocol.task.name)
    for trial, tables, seconds in finished:
        write_trial(
            folder,
            trial,
            tables,
            protocol_sha256=loaded.sha256,
            seconds=seconds,
            versions=made_with,
        )
        yield trial


def timed_trial(text: str, seeds: SeedSet, trial: int) -> Finished:
    """Run one trial in a worker; return its number, tables and seconds."""
    # Workers import what computes when they first need it.
    from study.experiment.trial import run_trial_from_text  # noqa: PLC0415

    with _one_at_a_time:
        began = time.perf_counter()
        tables = run_trial_from_text(text, seeds, trial)
        return trial, tables, time.perf_counter() - began
