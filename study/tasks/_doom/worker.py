"""A process with some of a fleet's engines: ``python -m study.tasks._doom.worker FD SETTINGS``.

It answers one request at a time: "place" and "step", each for the robots that the arena's
``asked`` names, with "done" or with what is wrong. It ends when the other end of its pipe is
closed, and the kernel ends it when the process that started it ends.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import shutil
import signal
import sys
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from study.tasks._doom.arena import Arena, ArenaPlace
from study.tasks._doom.conventions import TICS
from study.tasks._doom.cores import keep_to
from study.tasks._doom.engine import Command, Engine, EngineError, Pose, write_launcher

READY, DONE = b"ready", b"done"
_START_SECONDS = 60
_PARENT_DEATH = 1
_TOGETHER = 2
"""So many engines of a worker start at the same time."""


def main() -> None:
    """Serve until the pipe ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # An engine that never starts must not leave a process that waits for it.
    signal.alarm(_START_SECONDS)
    settings: dict[str, Any] = json.loads(sys.argv[2])
    pipe = Connection(int(sys.argv[1]))
    keep_to(settings["core"])
    scratch = Path(settings["scratch"])
    try:
        scratch.mkdir(mode=0o700)
        os.chdir(scratch)
        arena = Arena.open(ArenaPlace(**settings["arena"]))
        engines = _engines(settings, arena, pipe)
    except EngineError as error:
        with contextlib.suppress(OSError):
            pipe.send_bytes(str(error).encode())
        return
    except (EOFError, OSError):
        return
    finally:
        # Engines have open what they need. What has no name cannot be left behind.
        shutil.rmtree(scratch, ignore_errors=True)
    # Not before all engines run: until then their memory has names, which someone must remove.
    ctypes.CDLL(None).prctl(_PARENT_DEATH, signal.SIGKILL, 0, 0, 0)
    signal.alarm(0)
    if os.getppid() != settings["parent"]:
        return
    pipe.send_bytes(READY)
    while True:
        try:
            request = pipe.recv_bytes()
        except (EOFError, OSError):
            break
        try:
            _serve(request.decode(), arena, engines, every_tic=settings["every_tic"])
            answer = DONE
        except EngineError as error:
            answer = str(error).encode()
        try:
            pipe.send_bytes(answer)
        except OSError:
            break
    for engine in engines.values():
        engine.close()


def _engines(settings: dict[str, Any], arena: Arena, pipe: Connection) -> dict[int, Engine]:
    """Start the engines, by robot.

    Raises:
        EngineError: one does not start, or nobody waits for them any more.
    """
    path = Path.cwd() / "map.wad"
    path.write_bytes(pipe.recv_bytes())
    launcher = write_launcher(path.parent)
    place = arena.place

    def start(_: int) -> Engine:
        # Nothing is asked before we are ready: what can be read is the pipe's end.
        if os.getppid() != settings["parent"] or pipe.poll():
            raise EngineError("the fleet is gone")
        return Engine(path, launcher, place.width, place.height, tuple(settings["start"]))

    robots = range(*settings["robots"])
    with ThreadPoolExecutor(_TOGETHER) as pool:
        return dict(zip(robots, pool.map(start, robots), strict=True))


def _serve(request: str, arena: Arena, engines: dict[int, Engine], *, every_tic: bool) -> None:
    """Carry out a request for those of this process's robots that are asked."""
    shown = int(arena.turn[0])
    coming = arena.frames[1 - shown]

    for robot, engine in engines.items():
        if request == "place":
            if arena.asked[robot]:
                engine.place(Pose(*arena.poses[robot].tolist()))
                engine.copy_frame(arena.frames[shown, robot, -1])
                arena.frames[shown, robot, :-1] = arena.frames[shown, robot, -1]
        elif not arena.asked[robot]:
            coming[robot] = arena.frames[shown, robot, -1]
        else:
            forward, backward, turn = arena.commands[robot].tolist()
            command = Command(bool(forward), bool(backward), turn)
            arena.poses[robot] = engine.step(command, coming[robot] if every_tic else None)
            if not every_tic:
                engine.copy_frame(coming[robot, -1])
                coming[robot, : TICS - 1] = coming[robot, -1]


if __name__ == "__main__":
    main()
