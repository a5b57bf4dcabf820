"""How memory is asked for, so that what pictures took for a moment is given back."""

from __future__ import annotations

import ctypes
import sys

_M_MMAP_THRESHOLD = -3
LARGE = 32 << 10
"""Bytes from which a block is a mapping of its own, which is gone once it is freed."""


def give_large_blocks_back() -> None:
    """Let glibc take large blocks from the system, and never from among the small ones.

    Left alone glibc raises its threshold to as much as 32 MiB as soon as a block of that size was
    freed. From then on the large surfaces on which smooth shapes are painted lie between small
    ones that are kept, and the heap has holes: it grew by 50 MiB in a session of which not a byte
    more was in use. With a threshold of 128 KiB, just above a tile's surface, it still grew by
    a few MiB. Elsewhere nothing is done.
    """
    if not sys.platform.startswith("linux"):
        return
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, LARGE)
