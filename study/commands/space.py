"""A word on the disk before a session; `study preflight` says more."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rich.markup import escape

from study.commands.terminal import errors
from study.errors import StudyError
from study.loading import LoadedProtocol
from study.shell.fleet import open_emergency
from study.shell.preflight.machine import MEBIBYTE, disk_space, free_bytes

PLENTY_BYTES = 1 << 30
"""Many times what a session writes: where so much is free, none is rehearsed to measure it."""
PLENTY_FOR_PICTURES_BYTES = 16 << 30
"""The same where the robots' pictures are recorded."""


def tell_space(loaded: LoadedProtocol, folder: Path, recorded: Mapping[str, bytes]) -> None:
    """Warn, on one line, where a session may not fit on the disk; it may begin all the same.

    Args:
        loaded: the protocol.
        folder: of the recordings; need not exist yet.
        recorded: weights of other participants' scorers, by artefact id.
    """
    pictures = loaded.protocol.recording.pictures != "none"
    free = free_bytes(folder)
    if free >= (PLENTY_FOR_PICTURES_BYTES if pictures else PLENTY_BYTES):
        return
    need = _need(loaded, recorded)
    if need is None:
        said = f"{free / MEBIBYTE:,.0f} MiB free in {folder}; `study preflight` measures the need."
    else:
        check = disk_space(folder, need)
        if check.state == "green":
            return
        said = f"{check.found}; wanted: {check.wanted}. {check.advice}"
    errors.print(f"[yellow]The disk is nearly full:[/] {escape(said)}")


def _need(loaded: LoadedProtocol, recorded: Mapping[str, bytes]) -> int | None:
    """Return the bytes that a session records at most; None if none could be rehearsed."""
    # A session whose disk has room is spared the memory that these take.
    from study.commands.rehearsing import rehearse  # noqa: PLC0415
    from study.commands.simulating import simulated_assignments  # noqa: PLC0415

    task = loaded.protocol.task
    if button := open_emergency(task.name, task.parameters):
        # Real robots are not driven to measure what is written of it.
        button.close()
        return None
    try:
        with errors.status("Looking whether a session fits on the disk"):
            (assignment,) = simulated_assignments(loaded, 1, seed=1)
            return rehearse(loaded, assignment, recorded).bytes
    except StudyError:
        # A word on the disk must not keep a session from beginning.
        return None
