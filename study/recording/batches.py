"""Unpacks the chunks that hold what is wanted: half a MiB at a time, each message located."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import BinaryIO, Final

import numpy as np
import numpy.typing as npt
import zstandard

from study.recording.findings import Chunk
from study.recording.mcap_records import (
    MESSAGE_HEAD,
    MESSAGE_INDEX,
    RECORD,
    DamagedError,
    Messages,
    chunk_data,
    chunk_messages,
    messages_at,
)

BATCH_BYTES: Final = 2**19
"""Unpacked bytes of one batch, but for its last chunk: what fits into a processor's cache."""

_INDEX_HEAD: Final = RECORD.size + 6
_MESSAGE_HEAD_BYTES: Final = MESSAGE_HEAD.size


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Unpacked chunks, and where in them the messages wanted are.

    Attributes:
        messages: in order of sequence.
        data: the unpacked chunks, one after another.
    """

    messages: Messages
    data: bytes

    def up_to(self, sequence: int) -> Batch:
        """Return the batch without the messages of larger numbers."""
        return Batch(_chosen(self.messages, self.messages.sequence <= sequence), self.data)


def batches(stream: BinaryIO, chunks: Iterable[Chunk], channels: frozenset[int]) -> Iterator[Batch]:
    """Yield the messages of some channels.

    Args:
        stream: the file.
        chunks: in order of sequence; those that have none of the channels are not read.
        channels: which.

    Raises:
        DamagedError: a chunk is not what its checksum or its index says.
    """
    unpacker = zstandard.ZstdDecompressor()
    parts: list[bytes] = []
    places: list[npt.NDArray[np.int64]] = []
    size = 0
    for chunk in chunks:
        if chunk.channels.isdisjoint(channels):
            continue
        stream.seek(chunk.start)
        stored = stream.read(chunk.length + chunk.index_length)
        try:
            data = chunk_data(stored[: chunk.length], unpacker)
            found = _places(chunk, stored, data, channels)
        except DamagedError as error:
            raise DamagedError(f"the chunk at byte {chunk.start} is damaged: {error}") from error
        parts.append(data)
        places.append(found + size)
        size += len(data)
        if size >= BATCH_BYTES:
            yield _batch(parts, places, channels)
            parts, places, size = [], [], 0
    if parts:
        yield _batch(parts, places, channels)


def _places(
    chunk: Chunk, stored: bytes, data: bytes, channels: frozenset[int]
) -> npt.NDArray[np.int64]:
    """Return where in a chunk the records of messages begin: those of the channels, or all."""
    if chunk.index_places is None:
        return chunk_messages(data)[0].start - _MESSAGE_HEAD_BYTES
    found = []
    for channel in channels & chunk.channels:
        position = chunk.index_places[channel] - chunk.start
        head = stored[position : position + _INDEX_HEAD]
        if position < chunk.length or len(head) < _INDEX_HEAD:
            raise DamagedError("its message index is elsewhere")
        opcode, _ = RECORD.unpack_from(head)
        number = int.from_bytes(head[RECORD.size : RECORD.size + 2], "little")
        length = int.from_bytes(head[RECORD.size + 2 :], "little")
        begin = position + _INDEX_HEAD
        if opcode != MESSAGE_INDEX or number != channel or length % 16:
            raise DamagedError("its message index is malformed")
        if length > len(stored) - begin:
            raise DamagedError("its message index is cut off")
        found.append(np.frombuffer(stored, "<i8", length // 8, begin)[1::2])
    joined = np.concatenate(found)
    if joined.size and (int(joined.min()) < 0 or int(joined.max()) >= len(data)):
        raise DamagedError("its message index points beyond it")
    return joined


def _batch(
    parts: list[bytes], places: list[npt.NDArray[np.int64]], channels: frozenset[int]
) -> Batch:
    data = parts[0] if len(parts) == 1 else b"".join(parts)
    messages = messages_at(data, np.concatenate(places))
    wanted = np.isin(messages.channel, list(channels))
    if not wanted.all():
        messages = _chosen(messages, wanted)
    if (np.diff(messages.sequence.astype(np.int64)) <= 0).any():
        messages = _chosen(messages, np.argsort(messages.sequence, kind="stable"))
    return Batch(messages, data)


def _chosen(messages: Messages, which: npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> Messages:
    return Messages(
        messages.channel[which],
        messages.sequence[which],
        messages.log_time_ns[which],
        messages.start[which],
        messages.length[which],
    )
