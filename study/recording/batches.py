"""Unpacks the chunks that hold what is wanted: a MiB at a time, each message located."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import accumulate
from typing import BinaryIO, Final

import numpy as np
import numpy.typing as npt

from study.recording.mcap_chunks import (
    MESSAGE_HEAD,
    Chunk,
    Messages,
    chunk_data,
    chunk_messages,
    messages_at,
    rows_at,
    unpack_into,
)
from study.recording.mcap_records import MESSAGE_INDEX, DamagedError

BATCH_BYTES: Final = 2**20
"""Unpacked bytes of one batch, but for its last chunk: what fits into a processor's cache."""

_SKIPPED_BYTES: Final = 2**14
"""Bytes between two chunks that are rather read than leapt over."""

_INDEX_DTYPE: Final = np.dtype(
    [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("bytes", "<u4")]
)
_ENTRY_BYTES: Final = 16

Group = list[Chunk]


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

    def up_to(self, sequence: int) -> Batch:
        """Return the batch without the messages of larger numbers."""
        return Batch(_chosen(self.messages, self.messages.sequence <= sequence), self.data)


def batches(stream: BinaryIO, chunks: Iterable[Chunk], channels: frozenset[int]) -> Iterator[Batch]:
    """Yield the messages of some channels.

    While the caller works on one batch, a thread loads the next: reading, unpacking and
    checksums let go of Python's lock.

    Args:
        stream: the file.
        chunks: in order of sequence; those that have none of the channels are not read.
        channels: which.

    Raises:
        DamagedError: a chunk is not what its checksum or its index says.
    """
    groups = _groups(chunk for chunk in chunks if not chunk.channels.isdisjoint(channels))
    # One for the batch that is with the caller, one for the batch that is loaded.
    rooms = (_Room(), _Room())

    def load(number: int) -> Batch:
        return _load(stream, groups[number], channels, rooms[number % 2])

    yield from _one_ahead(load, len(groups))


def _groups(chunks: Iterable[Chunk]) -> list[Group]:
    """Return the chunks of each batch."""
    groups: list[Group] = []
    room = 0
    for chunk in chunks:
        if room <= 0:
            groups.append([])
            room = BATCH_BYTES
        groups[-1].append(chunk)
        room -= chunk.size
    return groups


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


def _load(stream: BinaryIO, group: Group, channels: frozenset[int], room: _Room) -> Batch:
    """Read and unpack some chunks, and find their messages."""
    stored, origins = _stored(stream, group, room)
    payloads = [
        stored[origin : origin + chunk.length] for origin, chunk in zip(origins, group, strict=True)
    ]
    begins = list(accumulate((chunk.size for chunk in group), initial=0))
    try:
        if len(group) == 1:
            data = memoryview(chunk_data(payloads[0]))
        else:
            data = room.data(begins[-1])
            unpack_into(data, payloads, [chunk.size for chunk in group])
    except DamagedError as error:
        raise _which(group, payloads, error) from error
    if any(chunk.index_places is None for chunk in group):
        places = chunk_messages(data)[0].start - MESSAGE_HEAD.size
    else:
        places = _indexed(stored, origins, group, begins, channels)
    messages = messages_at(data, places)
    wanted = np.isin(messages.channel, list(channels))
    if not wanted.all():
        messages = _chosen(messages, wanted)
    if (np.diff(messages.sequence.astype(np.int64)) <= 0).any():
        messages = _chosen(messages, np.argsort(messages.sequence, kind="stable"))
    return Batch(messages, data)


def _stored(stream: BinaryIO, group: Group, room: _Room) -> tuple[memoryview, list[int]]:
    """Return the bytes of chunks and their message indexes, and where in them each chunk begins."""
    # Chunks that follow one another, or nearly, are read at one go.
    runs: list[Group] = []
    first = 0
    for after in range(1, len(group) + 1):
        if after < len(group) and 0 <= group[after].start - group[after - 1].end < _SKIPPED_BYTES:
            continue
        runs.append(group[first:after])
        first = after
    stored = room.stored(sum(run[-1].end - run[0].start for run in runs))
    origins: list[int] = []
    begin = 0
    for run in runs:
        end = begin + run[-1].end - run[0].start
        stream.seek(run[0].start)
        if stream.readinto(stored[begin:end]) < end - begin:  # type: ignore[attr-defined]
            raise DamagedError("it became shorter while it was read")
        origins += [begin + chunk.start - run[0].start for chunk in run]
        begin = end
    return stored, origins


def _which(group: Group, payloads: list[memoryview], error: DamagedError) -> DamagedError:
    """Return the error that names the damaged chunk."""
    for chunk, payload in zip(group, payloads, strict=True):
        try:
            if len(chunk_data(bytes(payload))) != chunk.size:
                return _damaged(chunk, error)
        except DamagedError as found:
            return _damaged(chunk, found)
    return error


def _damaged(chunk: Chunk, why: object) -> DamagedError:
    return DamagedError(f"the chunk at byte {chunk.start} is damaged: {why}")


def _indexed(
    stored: memoryview,
    origins: list[int],
    group: Group,
    begins: list[int],
    channels: frozenset[int],
) -> npt.NDArray[np.int64]:
    """Return where in unpacked chunks the messages of some channels begin, by the message indexes.

    Args:
        stored: the chunks and their message indexes.
        origins: where in it each chunk begins.
        group: the chunks.
        begins: where each chunk's records begin once unpacked, and the end of the last.
        channels: which.
    """
    found: list[npt.NDArray[np.int64]] = []
    for channel in channels:
        held, heads_at, ends = [], [], []
        for number, (origin, chunk) in enumerate(zip(origins, group, strict=True)):
            place = (chunk.index_places or {}).get(channel)
            if place is None:
                continue
            held.append(number)
            heads_at.append(place - chunk.start + origin)
            ends.append(chunk.end - chunk.start + origin)
            if not chunk.start + chunk.length <= place <= chunk.end - _INDEX_DTYPE.itemsize:
                raise _damaged(chunk, "its message index is elsewhere")
        if not held:
            continue
        at = np.array(heads_at, np.int64)
        heads = rows_at(stored, at, _INDEX_DTYPE.itemsize).view(_INDEX_DTYPE).reshape(-1)
        begin = at + _INDEX_DTYPE.itemsize
        wrong = (heads["opcode"] != MESSAGE_INDEX) | (heads["channel"] != channel)
        wrong |= (heads["bytes"] % _ENTRY_BYTES != 0) | (begin + heads["bytes"] > np.array(ends))
        if wrong.any():
            raise _damaged(group[held[int(wrong.argmax())]], "its message index is malformed")
        counts = heads["bytes"].astype(np.int64) // _ENTRY_BYTES
        # Entries of time and place, 16 bytes each, as many as each index has.
        skipped = begin - _ENTRY_BYTES * (np.cumsum(counts) - counts)
        entries = np.repeat(skipped, counts) + _ENTRY_BYTES * np.arange(counts.sum())
        places = rows_at(stored, entries, _ENTRY_BYTES).view("<i8")[:, 1]
        starts = np.array(begins)
        room = np.repeat((starts[1:] - starts[:-1])[held], counts)
        beyond = (places < 0) | (places >= room)
        if beyond.any():
            where = np.repeat(held, counts)[int(beyond.argmax())]
            raise _damaged(group[where], "its message index points beyond it")
        found.append(places + np.repeat(starts[:-1][held], counts))
    return np.concatenate(found)


def _chosen(messages: Messages, which: npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> Messages:
    return Messages(
        messages.channel[which],
        messages.sequence[which],
        messages.log_time_ns[which],
        messages.start[which],
        messages.length[which],
    )
