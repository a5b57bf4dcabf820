"""A fleet's pictures packed for a recording: those that changed, compressed.

Packing is done where the task is stepped, after the fleet's answer is on its way: neither the
window nor a timestep waits for it.
"""

from __future__ import annotations

import dataclasses
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

Keep = Literal["none", "changed", "all"]
"""Which pictures of an answer are wanted for the recording."""

MAX_SIDE: Final = 4096
"""Longest side of a picture, pixels."""
MAX_BYTES: Final = 2**22
"""Longest picture, compressed."""
MAX_ROBOTS: Final = 1000
MAX_PIXELS: Final = 2**25
"""Of all robots' pictures together."""
MAX_DATA: Final = 2**24
"""Bytes of all pictures in one record."""
_SEVERAL = 5
"""Dimensions of several pictures of each robot."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Packed:
    """Pictures of one answer of the fleet, the last of each robot.

    Attributes:
        request_id: which StartFleet or StepFleet was answered.
        robots: how many there are, n.
        size: width and height of each picture, pixels.
        changed: robots with another picture than before, int32 [k], ascending.
        lengths: of their pictures, bytes, int32 [k].
        data: their pictures, one after another.
        failure: why there are none, in words; empty if there are.
    """

    request_id: int
    robots: int = 0
    size: tuple[int, int] = (0, 0)
    changed: npt.NDArray[np.int32] = dataclasses.field(default_factory=lambda: np.zeros(0, "i4"))
    lengths: npt.NDArray[np.int32] = dataclasses.field(default_factory=lambda: np.zeros(0, "i4"))
    data: bytes = b""
    failure: str = ""


class Packer:
    """Packs the pictures of one answer after another."""

    def __init__(self) -> None:
        self._before: npt.NDArray[np.uint8] | None = None

    def pack(self, request_id: int, pictures: npt.NDArray[np.uint8] | None, keep: Keep) -> Packed:
        """Pack the pictures that an answer came with.

        Args:
            request_id: of the answer.
            pictures: uint8 [n, height, width, 3], or [n, k, height, width, 3] of which the last
                counts; None if the task took none.
            keep: whether only those are wanted that are others than before.
        """
        from study.shell.jpeg import to_jpeg  # noqa: PLC0415 - it loads pygame; few pack anything

        if pictures is None:
            return Packed(request_id, failure="the task took no pictures")
        newest = pictures[:, -1] if pictures.ndim == _SEVERAL else pictures
        before, self._before = self._before, None
        if newest.size // 3 > MAX_PIXELS:
            return Packed(request_id, failure=f"they have more than {MAX_PIXELS} pixels together")
        anew = keep == "all" or before is None or before.shape != newest.shape
        changed = [
            robot
            for robot in range(len(newest))
            if anew or before is None or not np.array_equal(before[robot], newest[robot])
        ]
        try:
            packed = [to_jpeg(newest[robot]) for robot in changed]
        except Exception as error:  # a session goes on without its pictures
            return Packed(request_id, failure=str(error) or type(error).__name__)
        data = b"".join(packed)
        if len(data) > MAX_DATA:
            return Packed(request_id, failure=f"they have {len(data)} bytes, more than {MAX_DATA}")
        self._before = newest
        return Packed(
            request_id,
            robots=len(newest),
            size=(newest.shape[2], newest.shape[1]),
            changed=np.array(changed, np.int32),
            lengths=np.array([len(item) for item in packed], np.int32),
            data=data,
        )


def split(
    robots: int,
    size: tuple[int, int],
    changed: npt.NDArray[np.int32],
    lengths: npt.NDArray[np.int32],
    data: bytes,
) -> dict[int, bytes] | None:
    """Take apart what `Packer` put together; it may come from anybody.

    Args:
        robots: how many there are, n.
        size: width and height of each picture, pixels.
        changed: robots that have one, int32 [k].
        lengths: of their pictures, bytes, int32 [k].
        data: their pictures.

    Returns:
        Compressed pictures by robot; None where this is nothing that a recording may hold.
    """
    width, height = size
    if not (0 < robots <= MAX_ROBOTS and 0 < width <= MAX_SIDE):
        return None
    if not 0 < height <= MAX_SIDE or robots * width * height > MAX_PIXELS:
        return None
    if len(data) > MAX_DATA or len(changed) != len(lengths):
        return None
    places = changed.tolist()
    if places != sorted(set(places)) or not all(0 <= robot < robots for robot in places):
        return None
    sizes = lengths.tolist()
    if not all(0 < length <= MAX_BYTES for length in sizes) or sum(sizes) != len(data):
        return None
    ends = np.cumsum(lengths, dtype=np.int64).tolist()
    return {
        robot: data[end - length : end]
        for robot, length, end in zip(places, sizes, ends, strict=True)
    }
