"""Memory that the fleet's process, its workers and a window share; it leaves nothing behind.

It is an anonymous file of the kernel's: it has no name in any folder and ends with the last
process that has it open, however that ends. Others open it through the process that made it.
"""

from __future__ import annotations

import dataclasses
import mmap
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from study.tasks._doom.conventions import TICS

POSE, COMMAND = 6, 3
"""Numbers of an `engine.Pose` and of an `engine.Command`."""


@dataclasses.dataclass(frozen=True, slots=True)
class ArenaPlace:
    """How to open an arena: plain values to hand to another process.

    Attributes:
        path: of the memory.
        robots: n.
        height, width: of a picture, pixels.
    """

    path: str
    robots: int
    height: int
    width: int

    def sizes(self) -> dict[str, tuple[tuple[int, ...], type[np.generic]]]:
        """Return shape and kind of each array, in the order in which they lie."""
        n = self.robots
        return {
            "poses": ((n, POSE), np.int64),
            "commands": ((n, COMMAND), np.int64),
            "turn": ((1,), np.int64),
            "asked": ((n,), np.uint8),
            "frozen": ((n,), np.uint8),
            "frames": ((2, n, TICS, self.height, self.width, 3), np.uint8),
        }


class Arena:
    """The arrays of a fleet.

    Attributes:
        place: how to open it.
        poses: int64 [n, 6], an `engine.Pose` a robot.
        commands: int64 [n, 3], an `engine.Command` a robot.
        turn: int64 [1], which half of ``frames`` shows the last timestep.
        asked: uint8 [n], whom a request is about.
        frozen: uint8 [n], 1 while a robot waits for a new engine.
        frames: uint8 [2, n, 4, height, width, 3], the pictures of two timesteps by tic: the last
            whole one, and the one in the making.
    """

    def __init__(self, place: ArenaPlace, descriptor: int) -> None:
        self.place = place
        self._descriptor = descriptor
        total = 0
        offsets = {}
        for name, (shape, kind) in place.sizes().items():
            offsets[name] = total
            total += -(-int(np.prod(shape)) * np.dtype(kind).itemsize // 64) * 64
        if os.fstat(descriptor).st_size == 0:
            os.ftruncate(descriptor, total)
        memory = mmap.mmap(descriptor, total)
        arrays: dict[str, npt.NDArray[Any]] = {
            name: np.frombuffer(memory, kind, int(np.prod(shape)), offsets[name]).reshape(shape)
            for name, (shape, kind) in place.sizes().items()
        }
        self.poses: npt.NDArray[np.int64] = arrays["poses"]
        self.commands: npt.NDArray[np.int64] = arrays["commands"]
        self.turn: npt.NDArray[np.int64] = arrays["turn"]
        self.asked: npt.NDArray[np.uint8] = arrays["asked"]
        self.frozen: npt.NDArray[np.uint8] = arrays["frozen"]
        self.frames: npt.NDArray[np.uint8] = arrays["frames"]

    @classmethod
    def create(cls, robots: int, height: int, width: int) -> Arena:
        """Make the memory of a fleet."""
        descriptor = os.memfd_create("doom_fleet")
        path = f"/proc/{os.getpid()}/fd/{descriptor}"
        return cls(ArenaPlace(path, robots, height, width), descriptor)

    @classmethod
    def open(cls, place: ArenaPlace) -> Arena:
        """Open the memory that another process made.

        Raises:
            OSError: that process is gone.
        """
        return cls(place, os.open(Path(place.path), os.O_RDWR))

    def shown(self, tic: int = -1) -> npt.NDArray[np.uint8]:
        """Return the pictures of the last timestep after one of its tics.

        Returns:
            uint8 [n, height, width, 3], a view: it is painted over two timesteps later.
        """
        shown: npt.NDArray[np.uint8] = self.frames[int(self.turn[0]), :, tic]
        return shown

    def close(self) -> None:
        """Give up the memory; arrays that are still held keep it."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
