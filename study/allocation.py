"""How memory is asked for, so that what pictures took for a moment is given back."""

from __future__ import annotations

import ctypes
import functools
import sys
from typing import Any

_M_MMAP_THRESHOLD = -3
LARGE = 32 << 10
"""Bytes from which a block is a mapping of its own, which is gone once it is freed."""


@functools.cache
def _of_glibc(name: str) -> Any:  # noqa: ANN401 - a foreign function
    """Return a function of glibc; None elsewhere."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform.startswith("linux") else None


def give_large_blocks_back() -> None:
    """Let glibc take large blocks from the system, and never from among the small ones.

    Left alone glibc raises its threshold to as much as 32 MiB as soon as a block of that size was
    freed. From then on the large surfaces on which smooth shapes are painted lie between small
    ones that are kept, and the heap has holes: it grew by 50 MiB in a session of which not a byte
    more was in use. With a threshold of 128 KiB, just above a tile's surface, it still grew by
    a few MiB. Elsewhere nothing is done.
    """
    mallopt = _of_glibc("mallopt")
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, LARGE)


def give_holes_back() -> None:
    """Give pages among the small blocks that nothing uses back to the system.

    Else memory stays at the most that was ever in use at a time, and that most is surpassed by a
    little for hours. It takes about a tenth of a millisecond. Elsewhere nothing is done.
    """
    malloc_trim = _of_glibc("malloc_trim")
    if malloc_trim is not None:
        malloc_trim(0)
