"""Arrays that are filled from their beginning while a recording is read."""

from __future__ import annotations

from itertools import accumulate
from typing import Any

import numpy as np
import numpy.typing as npt

_ROOM_BYTES = 256 * 2**20
"""Most bytes of a topic that are reserved before they are there."""


class Growing:
    """An array that is filled from its beginning, so that nothing is copied twice.

    Args:
        room: for the first rows, [any, ...].
    """

    def __init__(self, room: npt.NDArray[Any]) -> None:
        self._room = room
        self._used = 0

    def extend(self, rows: npt.NDArray[Any]) -> None:
        """Add rows, [m, ...]."""
        end = self._used + len(rows)
        if end > len(self._room):
            room = np.empty((max(end, 2 * len(self._room)), *self._room.shape[1:]), rows.dtype)
            room[: self._used] = self._room[: self._used]
            self._room = room
        self._room[self._used : end] = rows
        self._used = end

    def array(self) -> npt.NDArray[Any]:
        """Return what was added."""
        return self._room[: self._used]


def growing_fields(dtype: np.dtype[Any], expected: int) -> dict[str, Growing]:
    """Return an array that grows for each field.

    Args:
        dtype: of one message.
        expected: messages for which there is to be room, as far as `_ROOM_BYTES` allow.
    """
    fields = {name: dtype[name] for name in dtype.names or ()}
    each = sum(field.itemsize for field in fields.values()) + 1
    rows = max(1, min(expected, _ROOM_BYTES // each))
    # One piece of memory for all: NumPy asks for large pages for large pieces only, and without
    # them the first touch of each page costs as much as the copying. What is never written
    # costs nothing.
    starts = list(accumulate((-(-rows * f.itemsize // 8) * 8 for f in fields.values()), initial=0))
    block = np.empty(starts[-1], np.uint8)
    return {
        name: Growing(
            block[start : start + rows * field.itemsize]
            .view(field.base)
            .reshape(rows, *field.shape)
        )
        for (name, field), start in zip(fields.items(), starts, strict=False)
    }
