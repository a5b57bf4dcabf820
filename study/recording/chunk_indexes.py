"""What the writer remembers of each chunk, in little memory.

A recording's index has one entry a chunk, and a chunk is closed every half second. mcap keeps the
entries as objects until the file is finished: some kilobytes each, so that a writer's memory grows
all through a session. Here they are kept as they will stand in the file, compressed, in room
that is taken at the start: what a long session lacks in memory shows before it begins.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Any, Protocol

from mcap.data_stream import RecordBuilder

BLOCK_BYTES = 1 << 15
"""Entries are compressed by so much: about a hundred, alike but for offsets and times."""
ROOM_BYTES = 1 << 19
"""Room taken at the start, for about an hour and a half; twice as much whenever it is full."""
_LENGTH = struct.Struct("<I")
"""Before each block: of how many bytes it is."""
_HEAD = struct.Struct("<BQ")
"""Of a record: its kind, and the length of the rest."""


class Entry(Protocol):
    """What can be written into an index."""

    def write(self, stream: RecordBuilder) -> None:
        """Append oneself to records."""
        ...


class _Written:
    """An entry that was encoded before."""

    __slots__ = ("_record",)

    def __init__(self, record: bytes) -> None:
        self._record = record

    def write(self, stream: RecordBuilder) -> None:
        """Append oneself to records."""
        stream.write(self._record)


class ChunkIndexes:
    """Entries of an index, in the order appended; stands in for the list that mcap's writer has."""

    def __init__(self) -> None:
        # Filled, since pages that nobody has written to are not there yet.
        self._room = bytearray(b"\xff" * ROOM_BYTES)
        self._end = 0
        self._open = bytearray()

    def append(self, entry: Entry) -> None:
        """Keep one more entry."""
        encoded = RecordBuilder()
        entry.write(encoded)
        self._open += encoded.end()  # type: ignore[no-untyped-call]
        if len(self._open) >= BLOCK_BYTES:
            self._keep(zlib.compress(self._open))
            self._open.clear()

    def _keep(self, block: bytes) -> None:
        end = self._end + _LENGTH.size + len(block)
        while end > len(self._room):
            self._room += bytes(len(self._room))
        self._room[self._end : end] = _LENGTH.pack(len(block)) + block
        self._end = end

    def __iter__(self) -> Iterator[Entry]:
        start = 0
        while start < self._end:
            (length,) = _LENGTH.unpack_from(self._room, start)
            start += _LENGTH.size
            yield from _records(zlib.decompress(self._room[start : start + length]))
            start += length
        yield from _records(bytes(self._open))


def _records(encoded: bytes) -> Iterator[Entry]:
    """Yield the records that stand one after another."""
    start = 0
    while start < len(encoded):
        _, length = _HEAD.unpack_from(encoded, start)
        end = start + _HEAD.size + length
        yield _Written(encoded[start:end])
        start = end


def keep_small(writer: Any) -> None:  # noqa: ANN401 - mcap's Writer is untyped
    """Let mcap's writer keep its chunk indexes so; call it before the first chunk.

    Raises:
        AttributeError: this version of mcap keeps them otherwise.
    """
    name = "_Writer__chunk_indices"
    if getattr(writer, name) != []:
        raise AttributeError(name)
    setattr(writer, name, ChunkIndexes())
