"""A fleet's pictures packed for a recording: those shown that changed, compressed.

Packing is done where the task is stepped, after the session has had the fleet's answer, and before
the next is asked for: neither the window nor a timestep waits for it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.recording.pictures import MAX_DATA, MAX_PIXELS

Pixels = npt.NDArray[np.uint8]

_SEVERAL = 5
"""Dimensions of several pictures of each robot."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Packed:
    """Pictures that came with one answer of the fleet.

    Attributes:
        request_id: which StartFleet or StepFleet was answered.
        robots: how many there are, n.
        size: width and height of each picture, pixels.
        shown: robots whose pictures were asked for, int32 [k], ascending.
        changed: those whose picture was not packed before, int32 [c], ascending.
        lengths: of their pictures, bytes, int32 [c].
        data: their pictures, one after another.
        failure: why there are none, in words; empty if there are.
    """

    request_id: int
    robots: int = 0
    size: tuple[int, int] = (0, 0)
    shown: npt.NDArray[np.int32] = dataclasses.field(default_factory=lambda: np.zeros(0, "i4"))
    changed: npt.NDArray[np.int32] = dataclasses.field(default_factory=lambda: np.zeros(0, "i4"))
    lengths: npt.NDArray[np.int32] = dataclasses.field(default_factory=lambda: np.zeros(0, "i4"))
    data: bytes = b""
    failure: str = ""


class Packer:
    """Packs pictures of one answer after another."""

    def __init__(self) -> None:
        self._request_id = -1
        self._kept: Pixels | None = None
        self._packed: dict[int, Pixels] = {}

    def keep(self, request_id: int, pictures: Pixels | None) -> None:
        """Keep the pictures of an answer until the next.

        Args:
            request_id: of the answer.
            pictures: uint8 [n, height, width, 3], or [n, k, height, width, 3] of which the last
                count; None if there are none to keep.
        """
        self._request_id = request_id
        several = pictures is not None and pictures.ndim == _SEVERAL
        self._kept = pictures[:, -1] if pictures is not None and several else pictures

    def pack(self, robots: tuple[int, ...], *, anew: bool) -> Packed:
        """Pack pictures of the answer kept.

        Args:
            robots: whose, from 0, ascending.
            anew: whether pictures are packed, too, that were packed before.
        """
        kept = self._kept
        if anew:
            self._packed.clear()
        if kept is None:
            return Packed(self._request_id, failure="the task took none")
        if kept.size // 3 > MAX_PIXELS:
            return Packed(self._request_id, failure=f"they have more than {MAX_PIXELS} pixels")
        try:
            changed = [each for each in robots if not self._is_packed(each, kept[each])]
            packed = [_compressed(kept[robot]) for robot in changed]
        except Exception as error:  # a session goes on without its pictures
            return Packed(self._request_id, failure=str(error) or type(error).__name__)
        data = b"".join(packed)
        if len(data) > MAX_DATA:
            return Packed(self._request_id, failure=f"they have more than {MAX_DATA} bytes")
        self._packed |= {robot: kept[robot].copy() for robot in changed}
        return Packed(
            self._request_id,
            robots=len(kept),
            size=(kept.shape[2], kept.shape[1]),
            shown=np.array(robots, np.int32),
            changed=np.array(changed, np.int32),
            lengths=np.array([len(item) for item in packed], np.int32),
            data=data,
        )

    def _is_packed(self, robot: int, pixels: Pixels) -> bool:
        before = self._packed.get(robot)
        return before is not None and np.array_equal(before, pixels)


def _compressed(pixels: Pixels) -> bytes:
    from study.shell.jpeg import to_jpeg  # noqa: PLC0415 - it loads pygame; few pack anything

    return to_jpeg(pixels)
