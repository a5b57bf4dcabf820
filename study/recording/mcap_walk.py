"""Walks an MCAP file in file order, and finds its way again after what is damaged."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import BinaryIO, Final

from study.recording.identity import PROFILE
from study.recording.mcap_records import (
    DATA_END,
    HEADER,
    MAGIC,
    MAX_RECORD_BYTES,
    RECORD,
    DamagedError,
    ExceedsError,
    TopLevel,
)

MAX_TOP_LEVEL_RECORDS: Final = 2_000_000
MAX_DAMAGED_PLACES: Final = 1_000

# A zstd-compressed chunk (opcode, length and 28 bytes, then the name of the compression, a
# length and zstd's own magic), or the metadata record that identifies a recording.
_LANDMARK: Final = re.compile(
    rb"\x06.{36}\x04\x00\x00\x00zstd.{8}\x28\xb5\x2f\xfd"
    + b"|\x0c.{8}"
    + len(PROFILE).to_bytes(4, "little")
    + PROFILE.encode(),
    re.DOTALL,
)
_LANDMARK_BYTES: Final = 64
_SEARCH_BYTES: Final = 2**20


def walk(
    stream: BinaryIO, size: int, take: Callable[[TopLevel], None], start: int = len(MAGIC)
) -> Iterator[tuple[int, int, DamagedError]]:
    """Hand every readable record of a file to `take`; yield the spans that are none.

    After a damaged place the search goes on for the next chunk, which its form shows and its
    checksum proves, or for the recording's metadata.

    Args:
        stream: the file.
        size: its length, bytes.
        take: gets each record in file order; raises DamagedError for one that is damaged.
        start: where to begin, bytes.

    Yields:
        For each damaged place its first byte, the byte after its last, and what is wrong.
    """
    position = start
    damaged = 0
    for _ in range(MAX_TOP_LEVEL_RECORDS):
        if position >= size:
            return
        try:
            record = record_at(stream, position, size)
            take(record)
            position = record.start + len(record.payload)
        except DamagedError as error:
            found = _next_landmark(stream, position + 1, size)
            yield position, found, error
            position = found
            damaged += 1
            if damaged > MAX_DAMAGED_PLACES:
                raise ExceedsError(f"more than {damaged - 1} places are damaged") from error
    raise ExceedsError(f"it has more than {MAX_TOP_LEVEL_RECORDS} records")


def record_at(stream: BinaryIO, position: int, size: int) -> TopLevel:
    """Return the record that begins at a place.

    Raises:
        DamagedError: it reaches beyond the end or is larger than any.
    """
    stream.seek(position)
    head = stream.read(RECORD.size)
    if len(head) < RECORD.size:
        raise DamagedError(f"it breaks off in the record at byte {position}")
    opcode, length = RECORD.unpack(head)
    start = position + RECORD.size
    if not HEADER <= opcode <= DATA_END:
        raise DamagedError(f"there is no record at byte {position}")
    if length > MAX_RECORD_BYTES:
        raise ExceedsError(
            f"the record at byte {position} would have {length} bytes, more than {MAX_RECORD_BYTES}"
        )
    if length > size - start:
        raise DamagedError(f"it breaks off in the record at byte {position}")
    payload = stream.read(length)
    if len(payload) < length:
        raise DamagedError(f"it breaks off in the record at byte {position}")
    return TopLevel(opcode, start, payload)


def _next_landmark(stream: BinaryIO, position: int, size: int) -> int:
    """Return where the next thing begins that looks like a chunk or our metadata, or `size`."""
    while position < size:
        stream.seek(position)
        found = _LANDMARK.search(stream.read(_SEARCH_BYTES + _LANDMARK_BYTES))
        if found:
            return position + found.start()
        position += _SEARCH_BYTES
    return size
