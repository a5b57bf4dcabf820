"""Unpacks the chunks that hold what is wanted: a MiB at a time, each message located."""

from __future__ import annotations

import bisect
import dataclasses
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import BinaryIO, Final

import numpy as np

from study.recording.mcap_chunks import (
    MESSAGE_HEAD,
    Messages,
    chunk_data,
    chunk_messages,
    messages_at,
    rows_at,
    unpack_into,
)
from study.recording.mcap_index import ChunkTable, Places
from study.recording.mcap_records import MESSAGE_INDEX, DamagedError

BATCH_BYTES: Final = 2**20
"""Unpacked bytes of one batch, but for its last chunk: what fits into a processor's cache."""

SOON_BYTES: Final = 2**16
"""The same where the first message is wanted soon, and perhaps few more."""

_SKIPPED_BYTES: Final = 2**14
"""Bytes between two chunks that are rather read than leapt over."""

_INDEX_DTYPE: Final = np.dtype(
    [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("bytes", "<u4")]
)
_ENTRY_BYTES: Final = 16


class _Room:
    """Memory for one batch after another: new memory for each costs as much as unpacking."""

    def __init__(self) -> None:
        self._stored = bytearray()
        self._data = bytearray()

    def stored(self, size: int) -> memoryview:
        """Return room for the bytes of the file."""
        if size > len(self._stored):
            self._stored = bytearray(size)
        return memoryview(self._stored)[:size]

    def data(self, size: int) -> memoryview:
        """Return room for unpacked chunks."""
        if size > len(self._data):
            self._data = bytearray(size)
        return memoryview(self._data)[:size]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Unpacked chunks, and where in them the messages wanted are.

    Attributes:
        messages: in order of sequence.
        data: the unpacked chunks, one after another; used again for another batch after the next
            one was asked for.
    """

    messages: Messages
    data: memoryview


def batches(
    stream: BinaryIO, chunks: ChunkTable, channels: frozenset[int], *, soon: bool = False
) -> Iterator[Batch]:
    """Yield the messages of some channels.

    While the caller works on one batch, a thread loads the next: reading, unpacking and
    checksums let go of Python's lock.

    Args:
        stream: the file.
        chunks: in order of sequence; those that have none of the channels are not read.
        channels: which.
        soon: whether the first message is wanted soon: little is loaded at once, nothing ahead.

    Raises:
        DamagedError: a chunk is not what its checksum or its index says.
    """
    held = chunks.holding(channels)
    # One for the batch that is with the caller, one for the batch that is loaded.
    rooms = (_Room(), _Room())
    if soon:
        for number, group in enumerate(_groups(held, SOON_BYTES)):
            yield _load(stream, group, channels, rooms[number % 2])
        return
    groups = list(_groups(held, BATCH_BYTES))

    def load(number: int) -> Batch:
        return _load(stream, groups[number], channels, rooms[number % 2])

    yield from _one_ahead(load, len(groups))


def chunks_from(stream: BinaryIO, chunks: ChunkTable, log_time_ns: int) -> ChunkTable:
    """Return the chunks from the last one on that begins before a time. None is unpacked.

    Args:
        stream: the file.
        chunks: in order of sequence.
        log_time_ns: nanoseconds since 1970, UTC.
    """

    def begins(number: int) -> int:
        # A chunk's first eight bytes are the time of its first message.
        stream.seek(int(chunks.start[number]))
        return int.from_bytes(stream.read(8), "little")

    number = bisect.bisect_left(range(len(chunks)), log_time_ns, key=begins)
    return chunks.rows(slice(max(0, number - 1), None))


def _groups(chunks: ChunkTable, batch_bytes: int) -> Iterator[ChunkTable]:
    """Yield the chunks of each batch."""
    total = np.cumsum(chunks.size)
    first, before = 0, 0
    while first < len(chunks):
        after = int(np.searchsorted(total, before + batch_bytes)) + 1
        yield chunks.rows(slice(first, after))
        first, before = after, int(total[min(after, len(chunks)) - 1])


def _one_ahead(load: Callable[[int], Batch], count: int) -> Iterator[Batch]:
    """Yield the batches in order."""
    if count < 2:
        yield from map(load, range(count))
        return
    executor = ThreadPoolExecutor(1, "read-ahead")
    try:
        ahead = executor.submit(load, 0)
        for number in range(1, count):
            ready, ahead = ahead.result(), executor.submit(load, number)
            yield ready
        yield ahead.result()
    finally:
        # The stream is not ours to keep: nothing reads it after this.
        executor.shutdown(cancel_futures=True)


def _load(stream: BinaryIO, chunks: ChunkTable, channels: frozenset[int], room: _Room) -> Batch:
    """Read and unpack some chunks, and find their messages."""
    stored, origins = _stored(stream, chunks, room)
    begins = np.cumsum(chunks.size) - chunks.size
    if len(chunks) == 1:
        data = memoryview(_one_chunk(chunks, stored, origins, 0))
    else:
        try:
            data = room.data(int(chunks.size.sum()))
            unpack_into(data, stored, origins, chunks.length, chunks.size)
        except DamagedError:
            # Either this says which of them is damaged, or they are packed in another way.
            parts = [_one_chunk(chunks, stored, origins, number) for number in range(len(chunks))]
            data = memoryview(b"".join(parts))
    if chunks.indexed:
        places = _indexed(stored, origins, chunks, begins, channels)
    else:
        places = chunk_messages(data)[0].start - MESSAGE_HEAD.size
    messages = messages_at(data, places)
    wanted = np.isin(messages.channel, list(channels))
    if not wanted.all():
        messages = messages.chosen(wanted)
    if (np.diff(messages.sequence.astype(np.int64)) <= 0).any():
        messages = messages.chosen(np.argsort(messages.sequence, kind="stable"))
    return Batch(messages, data)


def _stored(stream: BinaryIO, chunks: ChunkTable, room: _Room) -> tuple[memoryview, Places]:
    """Return the bytes of chunks and their message indexes, and where in them each chunk begins."""
    between = chunks.start[1:] - chunks.end[:-1]
    # Chunks that follow one another, or nearly, are read at one go.
    breaks = np.flatnonzero((between < 0) | (between >= _SKIPPED_BYTES)) + 1
    firsts, lasts = np.append(0, breaks), np.append(breaks, len(chunks)) - 1
    lengths = chunks.end[lasts] - chunks.start[firsts]
    begins = np.cumsum(lengths) - lengths
    stored = room.stored(int(lengths.sum()))
    for start, begin, length in zip(
        chunks.start[firsts].tolist(), begins.tolist(), lengths.tolist(), strict=True
    ):
        stream.seek(start)
        if stream.readinto(stored[begin : begin + length]) < length:  # type: ignore[attr-defined]
            raise DamagedError("it became shorter while it was read")
    shifts = np.repeat(begins - chunks.start[firsts], lasts - firsts + 1)
    return stored, chunks.start + shifts


def _one_chunk(chunks: ChunkTable, stored: memoryview, origins: Places, number: int) -> bytes:
    """Return one chunk's records."""
    origin = int(origins[number])
    try:
        data = chunk_data(stored[origin : origin + int(chunks.length[number])])
    except DamagedError as error:
        raise _damaged(chunks, number, error) from error
    if len(data) != chunks.size[number]:
        raise _damaged(chunks, number, "its size is not what the index says")
    return data


def _damaged(chunks: ChunkTable, number: int, why: object) -> DamagedError:
    return DamagedError(f"the chunk at byte {chunks.start[number]} is damaged: {why}")


def _indexed(
    stored: memoryview,
    origins: Places,
    chunks: ChunkTable,
    begins: Places,
    channels: frozenset[int],
) -> Places:
    """Return where in unpacked chunks the messages of some channels begin, by the message indexes.

    Args:
        stored: the chunks and their message indexes.
        origins: where in it each chunk begins.
        chunks: which.
        begins: where each chunk's records begin once unpacked.
        channels: which.
    """
    found: list[Places] = []
    for channel in channels & chunks.places.keys():
        held = np.flatnonzero(chunks.places[channel])
        if not held.size:
            continue
        place = chunks.places[channel][held]
        after = chunks.start[held] + chunks.length[held]
        wrong = (place < after) | (place > chunks.end[held] - _INDEX_DTYPE.itemsize)
        if wrong.any():
            number = int(held[wrong.argmax()])
            raise _damaged(chunks, number, "its message index is elsewhere")
        shift = origins[held] - chunks.start[held]
        rows = rows_at(stored, place + shift, _INDEX_DTYPE.itemsize)
        heads = rows.view(_INDEX_DTYPE).reshape(-1)
        begin = place + shift + _INDEX_DTYPE.itemsize
        wrong = (heads["opcode"] != MESSAGE_INDEX) | (heads["channel"] != channel)
        wrong |= heads["bytes"] % _ENTRY_BYTES != 0
        wrong |= begin + heads["bytes"] > chunks.end[held] + shift
        if wrong.any():
            number = int(held[wrong.argmax()])
            raise _damaged(chunks, number, "its message index is malformed")
        counts = heads["bytes"].astype(np.int64) // _ENTRY_BYTES
        # Entries of time and place, 16 bytes each, as many as each index has.
        skipped = begin - _ENTRY_BYTES * (np.cumsum(counts) - counts)
        entries = np.repeat(skipped, counts) + _ENTRY_BYTES * np.arange(counts.sum())
        places = rows_at(stored, entries, _ENTRY_BYTES).view("<i8")[:, 1]
        beyond = (places < 0) | (places >= np.repeat(chunks.size[held], counts))
        if beyond.any():
            number = int(np.repeat(held, counts)[beyond.argmax()])
            raise _damaged(chunks, number, "its message index points beyond it")
        found.append(places + np.repeat(begins[held], counts))
    return np.concatenate(found)
