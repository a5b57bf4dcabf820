"""Frames on the two pipes between a study and its writer process.

A frame is one byte of kind, four bytes of length (little-endian) and that many bytes. This
module is loaded by the writer process, so it imports the standard library only.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from enum import IntEnum
from typing import Final

MAX_PAYLOAD: Final = 256 * 2**20
"""Longest payload of one frame, bytes."""

MESSAGE_HEADER: Final = struct.Struct("<HIQI")
"""Before each encoded record of MESSAGES: channel, sequence number, log time in ns, length."""

SEQUENCE: Final = struct.Struct("<I")
"""The payload of DURABLE: the last sequence number known to be on disk."""

_HEADER: Final = struct.Struct("<BI")


class FrameKind(IntEnum):
    """What a frame says; the first three go to the writer, the others come from it."""

    OPEN = 1
    """JSON: what the file is made of, see `study.recording.writer`."""
    MESSAGES = 2
    """One or more records that belong together: all of them get into the file, or none."""
    SYNC = 3
    """Empty: bring everything so far to the disk now."""
    READY = 4
    """Empty: the file exists and its start is on disk."""
    DURABLE = 5
    FAILED = 6
    """JSON: message, hint, and whether the file itself is lost. The writer has given up."""
    FINISHED = 7
    """The path of the finished file, UTF-8."""
    REMARK = 8
    """Words, UTF-8: something went wrong outside and was mended."""


def frame(kind: FrameKind, *pieces: bytes) -> bytes:
    """Return one frame, whose payload is given in pieces so that it is copied once only.

    Raises:
        ValueError: the payload is longer than `MAX_PAYLOAD`.
    """
    length = sum(map(len, pieces))
    if length > MAX_PAYLOAD:
        raise ValueError(f"{length} bytes are more than the {MAX_PAYLOAD} of one frame")
    return b"".join((_HEADER.pack(kind, length), *pieces))


def split_messages(payload: bytes) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield channel, sequence number, log time (ns) and bytes of each record of MESSAGES."""
    position = 0
    while position < len(payload):
        channel, sequence, log_time_ns, length = MESSAGE_HEADER.unpack_from(payload, position)
        position += MESSAGE_HEADER.size
        yield channel, sequence, log_time_ns, payload[position : position + length]
        position += length


class FrameSplitter:
    """Cuts what comes out of a pipe into frames; an unfinished last one stays inside."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[FrameKind, bytes]]:
        """Add what was read, and return the frames that are now whole.

        Raises:
            ValueError: the bytes are no frames.
        """
        buffer = self._buffer
        buffer += data
        position = 0
        try:
            while len(buffer) - position >= _HEADER.size:
                kind, length = _HEADER.unpack_from(buffer, position)
                if length > MAX_PAYLOAD:
                    raise ValueError(f"a frame of {length} bytes")
                start = position + _HEADER.size
                if len(buffer) < start + length:
                    break
                position = start + length
                yield FrameKind(kind), bytes(buffer[start:position])
        finally:
            del buffer[:position]
