"""Pictures on their way from the fleet's process to the window's: through memory that both share.

Twelve pictures of DOOM are three megabytes a timestep. Through a pipe they hold the window up
for longer than it has between two pictures of the display; from shared memory they are copied in
a tenth of that. The memory is an anonymous file of the kernel's: it has no name in any folder and
ends with the last process that has it open, however that ends.
"""

from __future__ import annotations

import dataclasses
import math
import mmap
import os

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[np.uint8]


@dataclasses.dataclass(frozen=True, slots=True)
class Laid:
    """Where pictures lie, until the next ones are asked for.

    Attributes:
        path: of the memory.
        size: of the memory, bytes.
        shape: of the pictures.
    """

    path: str
    size: int
    shape: tuple[int, ...]


class PictureShelf:
    """The end that lays pictures down; one set at a time."""

    def __init__(self) -> None:
        self._descriptor = -1
        self._memory: mmap.mmap | None = None
        self._size = 0

    def lay(self, pictures: Pixels) -> Laid:
        """Lay pictures where the other end can take them, before it asks for others.

        Raises:
            OSError: there is no such memory.
        """
        if pictures.nbytes > self._size or self._memory is None:
            self.close()
            self._descriptor = os.memfd_create("pictures")
            self._size = max(1, pictures.nbytes)
            os.ftruncate(self._descriptor, self._size)
            self._memory = mmap.mmap(self._descriptor, self._size)
        count = math.prod(pictures.shape)
        into = np.frombuffer(self._memory, np.uint8, count).reshape(pictures.shape)
        into[...] = pictures
        return Laid(f"/proc/{os.getpid()}/fd/{self._descriptor}", self._size, pictures.shape)

    def close(self) -> None:
        """Give the memory up; who has it open keeps it. Calling it twice is harmless."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor, self._memory, self._size = -1, None, 0


class PictureTaker:
    """The end that takes them."""

    def __init__(self) -> None:
        self._open: tuple[str, int] = ("", 0)
        self._memory: mmap.mmap | None = None

    def take(self, laid: Laid) -> Pixels:
        """Return a copy of the pictures.

        Raises:
            OSError: the memory cannot be opened.
        """
        if self._open != (laid.path, laid.size) or self._memory is None:
            descriptor = os.open(laid.path, os.O_RDONLY)
            try:
                self._memory = mmap.mmap(descriptor, laid.size, prot=mmap.PROT_READ)
            finally:
                os.close(descriptor)
            self._open = (laid.path, laid.size)
        count = math.prod(laid.shape)
        return np.frombuffer(self._memory, np.uint8, count).reshape(laid.shape).copy()


def can_share() -> bool:
    """Whether this platform has such memory."""
    return hasattr(os, "memfd_create")
