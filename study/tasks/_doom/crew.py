"""The engines of a fleet, spread over processes that are watched and replaced when they fail."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import uuid
import weakref
from collections.abc import Callable
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import numpy.typing as npt

import study
from study.errors import StudyError
from study.tasks._doom.arena import Arena
from study.tasks._doom.cores import cores_of
from study.tasks._doom.leftovers import memory_of, sweep_memory
from study.tasks._doom.worker import DONE, READY

_START_SECONDS = 60.0
_LEAVE_SECONDS = 5.0
"""For so long a worker is given to end by itself; one that starts an engine finishes that."""

_ATTEMPTS = 3
"""So many times in a row a request may cost the engines that it was sent to."""

Mask = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.int64]


@dataclasses.dataclass(frozen=True, slots=True)
class Incident:
    """Engines that were replaced.

    Attributes:
        robots: whose they were.
        reason: what was noticed.
        seconds: from the request to the answer of the new engines.
    """

    robots: tuple[int, ...]
    reason: str
    seconds: float


@dataclasses.dataclass(frozen=True, slots=True)
class Change:
    """Robots that lost their engines, or have them again.

    Attributes:
        robots: whose they are.
        lost: False if they are replaced.
        reason: what was noticed.
        seconds: since the request that they failed at.
    """

    robots: tuple[int, ...]
    lost: bool
    reason: str
    seconds: float


class _Lost(Exception):  # noqa: N818 - told to nobody outside
    """A worker that is of no more use."""


class _Worker:
    """A process with the engines of robots ``first`` to ``last`` - 1, and the pipe to it."""

    def __init__(self, crew: Crew, first: int, last: int, core: int | None) -> None:
        self.core = core
        self.robots = slice(first, last)
        self.indices = tuple(range(first, last))
        self.scratch = Path(tempfile.gettempdir()) / f"doom_{uuid.uuid4().hex}"
        ours, theirs = socket.socketpair()
        settings = {
            "arena": dataclasses.asdict(crew.arena.place),
            "robots": [first, last],
            "start": crew.start,
            "every_tic": crew.every_tic,
            "parent": os.getpid(),
            "core": core,
            # The worker makes it and takes it away: it outlives us while its engines start.
            "scratch": str(self.scratch),
        }
        source = str(Path(study.__file__ or "").parent.parent)
        inherited = os.environ.get("PYTHONPATH")
        with theirs:
            # Not multiprocessing: a fleet's own process may have no such children.
            self.process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "study.tasks._doom.worker",
                    str(theirs.fileno()),
                    json.dumps(settings),
                ],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env={
                    **os.environ,
                    "PYTHONPATH": os.pathsep.join([source, inherited] if inherited else [source]),
                    "OMP_NUM_THREADS": "1",
                    "OPENBLAS_NUM_THREADS": "1",
                },
                start_new_session=True,
            )
        self.pipe = Connection(ours.detach())
        with contextlib.suppress(OSError):
            self.pipe.send_bytes(crew.wad)

    def send(self, request: str) -> None:
        """Ask; whether it was heard shows when the answer is due."""
        try:
            self.pipe.send_bytes(request.encode())
        except OSError:
            return

    def expect(self, answer: bytes, until: float) -> None:
        """Wait for an answer.

        Raises:
            _Lost: another comes, or none until then, or the process has ended.
        """
        try:
            if not self.pipe.poll(max(0.0, until - time.monotonic())):
                raise _Lost("no answer in time")
            given = self.pipe.recv_bytes(65536)
        except (EOFError, OSError):
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(_LEAVE_SECONDS)
            raise _Lost(f"the process ended, status {self.process.returncode}") from None
        if given != answer:
            raise _Lost(given.decode(errors="replace"))

    def end(self, *, politely: bool) -> None:
        """End the process, and with it its engines. Calling it twice is harmless."""
        self.pipe.close()
        if politely:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(_LEAVE_SECONDS)
        named = memory_of(self.process.pid)
        self.process.kill()
        self.process.wait()
        for path in named:
            path.unlink(missing_ok=True)
        shutil.rmtree(self.scratch, ignore_errors=True)


class Crew:
    """All engines of a fleet.

    Engines die with the thread that made the crew, as they do with its process.

    Args:
        robots: number of robots, n.
        wad: the map.
        start: where it puts the player, 1/GRID map units.
        frame: height and width of a picture, pixels.
        every_tic: draw every tic, not only the last of a timestep.
        workers: how many processes share the engines.
        patience: seconds after which an engine that does not answer is replaced.
        on_change: told when engines are found to have failed, and when others are in their place.

    Attributes:
        arena: what is shared with the workers; a window may open it too.
        incidents: what went wrong so far, oldest first.
    """

    def __init__(
        self,
        robots: int,
        wad: bytes,
        start: tuple[int, int],
        frame: tuple[int, int],
        *,
        every_tic: bool,
        workers: int,
        patience: float,
        on_change: Callable[[Change], None] = lambda _: None,
    ) -> None:
        self.wad, self.start, self.every_tic = wad, start, every_tic
        self.arena = Arena.create(robots, *frame)
        self.incidents: list[Incident] = []
        self._patience = patience
        self._on_change = on_change
        self._placed = np.zeros(robots, np.bool_)
        self._known = np.zeros_like(self.arena.poses)
        edges = np.linspace(0, robots, min(workers, robots) + 1).round().astype(int).tolist()
        self._workers: list[_Worker] = []
        self._finalizer = weakref.finalize(self, _end, self._workers, self.arena)
        sweep_memory()
        cores = cores_of(len(edges) - 1, os.getpid())
        self._workers += [
            _Worker(self, *ends, core) for ends, core in zip(pairwise(edges), cores, strict=True)
        ]
        for number, worker in enumerate(self._workers):
            try:
                worker.expect(READY, time.monotonic() + _START_SECONDS)
            except _Lost as lost:
                self._replace(number, str(lost), attempts=1)

    def place(self, mask: Mask, poses: Numbers) -> None:
        """Put the robots in ``mask`` [n] into ``poses`` int64 [n, 6].

        Raises:
            StudyError: engines fail again and again.
        """
        self._known[mask] = poses[mask]
        self._placed |= mask
        self.arena.poses[...] = self._known
        self._ask("place", mask)

    def step(self, mask: Mask, commands: Numbers) -> Numbers:
        """Take a timestep with the robots in ``mask`` [n] by ``commands`` int64 [n, 3].

        Returns:
            The poses of all robots, int64 [n, 6].

        Raises:
            StudyError: engines fail again and again.
        """
        self.arena.commands[...] = commands
        self._ask("step", mask)
        self.arena.turn[0] = 1 - self.arena.turn[0]
        self._known[mask] = self.arena.poses[mask]
        return self._known.copy()

    def pids(self) -> list[int]:
        """Return the ids of the workers' processes."""
        return [worker.process.pid for worker in self._workers]

    def close(self) -> None:
        """End all engines. Calling it twice is harmless."""
        self._finalizer()

    def _ask(self, request: str, mask: Mask) -> None:
        """Have every worker carry out a request; replace those that do not."""
        begun = time.monotonic()
        self.arena.asked[...] = mask
        for worker in self._workers:
            worker.send(request)
        until = time.monotonic() + self._patience
        lost: dict[int, str] = {}
        for number, worker in enumerate(self._workers):
            try:
                worker.expect(DONE, until)
            except _Lost as error:
                lost[number] = str(error)
        for number, reason in lost.items():
            self.arena.frozen[self._workers[number].robots] = 1
            since = time.monotonic() - begun
            self._on_change(
                Change(self._workers[number].indices, lost=True, reason=reason, seconds=since)
            )
        for number, reason in lost.items():
            self._retry(number, reason, request, mask)
            worker = self._workers[number]
            self.arena.frozen[worker.robots] = 0
            since = time.monotonic() - begun
            self.incidents.append(Incident(worker.indices, reason, since))
            self._on_change(Change(worker.indices, lost=False, reason=reason, seconds=since))

    def _retry(self, number: int, reason: str, request: str, mask: Mask) -> None:
        """Replace a worker and give it the request again that it failed at."""
        for attempt in range(1, _ATTEMPTS + 1):
            self._replace(number, reason, attempts=attempt)
            worker = self._workers[number]
            try:
                # The new engines know nothing: all robots are put where they were before.
                self.arena.poses[worker.robots] = self._known[worker.robots]
                self.arena.asked[...] = self._placed
                worker.send("place")
                worker.expect(DONE, time.monotonic() + _START_SECONDS)
                self.arena.asked[...] = mask
                if request != "place":
                    worker.send(request)
                    worker.expect(DONE, time.monotonic() + self._patience)
            except _Lost as lost:
                reason = str(lost)
            else:
                return
        self._give_up(reason)

    def _replace(self, number: int, reason: str, attempts: int) -> None:
        """End a worker and start another in its place."""
        for _ in range(attempts, _ATTEMPTS + 1):
            old = self._workers[number]
            old.end(politely=False)
            sweep_memory()
            self._workers[number] = _Worker(self, old.robots.start, old.robots.stop, old.core)
            try:
                self._workers[number].expect(READY, time.monotonic() + _START_SECONDS)
            except _Lost as lost:
                reason = str(lost)
            else:
                return
        self._give_up(reason)

    def _give_up(self, reason: str) -> None:
        self.close()
        raise StudyError(
            f"the DOOM engines failed {_ATTEMPTS} times in a row: {reason}",
            "Check that `python -c 'import vizdoom'` works and that memory and /tmp are not full.",
        )


def _end(workers: list[_Worker], arena: Arena) -> None:
    for worker in workers:
        worker.pipe.close()
    for worker in workers:
        worker.end(politely=True)
    workers.clear()
    arena.close()
