"""The chunks of an MCAP file, and the messages in them, taken apart without trusting either."""

from __future__ import annotations

import dataclasses
import struct
import zlib
from typing import Final

import numpy as np
import numpy.typing as npt
import zstandard

from study.recording.mcap_records import (
    CHANNEL,
    MAX_CHUNK_BYTES,
    MESSAGE,
    RECORD,
    SCHEMA,
    DamagedError,
    Declaration,
    ExceedsError,
    declaration,
    text_at,
)

MAX_CHUNK_MESSAGES: Final = 100_000

MESSAGE_HEAD: Final = struct.Struct("<BQHIQQ")
_CHUNK = struct.Struct("<QQQI")
_U64 = struct.Struct("<Q")
_ZSTD_HEAD: Final = np.dtype(
    [
        ("first_ns", "<u8"),
        ("last_ns", "<u8"),
        ("size", "<u8"),
        ("checksum", "<u4"),
        ("name_bytes", "<u4"),
        ("name", "S4"),
        ("packed", "<u8"),
    ]
)
_MESSAGE_DTYPE: Final = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Messages:
    """Messages, of one chunk or of several, without their data.

    Attributes:
        channel: uint16 [m].
        sequence: uint32 [m].
        log_time_ns: uint64 [m].
        start: place of the data in the uncompressed bytes, int64 [m].
        length: of the data, bytes, int64 [m].
    """

    channel: npt.NDArray[np.uint16]
    sequence: npt.NDArray[np.uint32]
    log_time_ns: npt.NDArray[np.uint64]
    start: npt.NDArray[np.int64]
    length: npt.NDArray[np.int64]

    def chosen(self, which: slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> Messages:
        """Return some of the messages."""
        return Messages(
            self.channel[which],
            self.sequence[which],
            self.log_time_ns[which],
            self.start[which],
            self.length[which],
        )


def chunk_data(payload: bytes | memoryview) -> bytes:
    """Return a chunk's records, uncompressed and checked.

    Args:
        payload: the chunk, without opcode and length.

    Raises:
        DamagedError: the chunk is not what its checksum says, or too large.
    """
    size, checksum, compression, packed = _taken_apart(memoryview(payload))
    try:
        if compression == "zstd":
            # The frame's own statement decides how much is allocated.
            if zstandard.get_frame_parameters(packed).content_size != size:
                raise DamagedError("its sizes contradict each other")
            data: bytes = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        else:
            data = bytes(packed)
    except (zstandard.ZstdError, MemoryError) as error:
        raise DamagedError(f"it cannot be unpacked ({error})") from error
    if len(data) != size or zlib.crc32(data) != checksum:
        raise DamagedError("its checksum is wrong")
    return data


def unpack_into(
    room: memoryview,
    stored: memoryview,
    origins: npt.NDArray[np.int64],
    lengths: npt.NDArray[np.int64],
    sizes: npt.NDArray[np.int64],
) -> None:
    """Write the records of several chunks, one chunk after another, uncompressed and checked.

    One call unpacks all, without Python's lock: most chunks are so small that a call for each
    would take as long again.

    Args:
        room: for all of it, writable, [sum of sizes].
        stored: a piece of the file.
        origins: where in it each chunk begins, without opcode and length [c].
        lengths: of the chunks, bytes [c].
        sizes: of each one's records, bytes: what is allocated [c].

    Raises:
        DamagedError: one of them is not what its checksum or its size says; which one, `chunk_data`
            tells.
    """
    if int(lengths.min()) < _ZSTD_HEAD.itemsize:
        raise DamagedError("it is cut off")
    heads = rows_at(stored, origins, _ZSTD_HEAD.itemsize).view(_ZSTD_HEAD).reshape(-1)
    packed = lengths - _ZSTD_HEAD.itemsize
    usual = (heads["name_bytes"] == 4) & (heads["name"] == b"zstd") & (heads["size"] == sizes)
    if not (usual & (heads["packed"] == packed)).all():
        raise DamagedError("it is not packed as recordings are")
    frames = np.stack([origins + _ZSTD_HEAD.itemsize, packed], axis=1).astype("<u8")
    try:
        segments = zstandard.ZstdDecompressor().multi_decompress_to_buffer(
            zstandard.BufferWithSegments(stored, frames.tobytes()),
            decompressed_sizes=sizes.astype("<u8").tobytes(),
        )
    except (zstandard.ZstdError, MemoryError, ValueError, TypeError) as error:
        raise DamagedError(f"it cannot be unpacked ({error})") from error
    begin = 0
    for number, checksum in enumerate(heads["checksum"].tolist()):
        part = memoryview(segments[number])  # type: ignore[arg-type] # a segment has a buffer
        if zlib.crc32(part) != checksum:
            raise DamagedError("its checksum is wrong")
        room[begin : begin + len(part)] = part
        begin += len(part)


def _taken_apart(payload: memoryview) -> tuple[int, int, str, memoryview]:
    """Return a chunk's unpacked size (bytes), checksum, compression, and packed records.

    Raises:
        DamagedError: it is cut off, contradicts itself or is compressed in a way unknown.
        ExceedsError: it is larger than any.
    """
    if len(payload) < _CHUNK.size:
        raise DamagedError("it is cut off")
    _, _, size, checksum = _CHUNK.unpack_from(payload)
    if size > MAX_CHUNK_BYTES:
        raise ExceedsError(f"it would have {size} bytes, more than {MAX_CHUNK_BYTES}")
    try:
        compression, position = text_at(payload, _CHUNK.size)
        (length,) = _U64.unpack_from(payload, position)
    except (struct.error, UnicodeDecodeError) as error:
        raise DamagedError(f"it cannot be unpacked ({error})") from error
    packed = payload[position + _U64.size :]
    if length != len(packed):
        raise DamagedError("its length is wrong")
    if compression not in {"zstd", ""}:
        raise DamagedError(f'its compression "{compression[:20]}" is not supported')
    return size, checksum, compression, packed


def chunk_messages(data: bytes | memoryview) -> tuple[Messages, list[Declaration]]:
    """Return where a chunk's messages are, and the schemas and channels it declares.

    Raises:
        DamagedError: the records do not fill the chunk, or are too many.
    """
    places: list[int] = []
    declared: list[Declaration] = []
    position, size = 0, len(data)
    try:
        while position < size:
            opcode, length = RECORD.unpack_from(data, position)
            start = position + RECORD.size
            if length > size - start:
                raise DamagedError("a record reaches beyond its end")
            if opcode == MESSAGE:
                places.append(position)
                if len(places) > MAX_CHUNK_MESSAGES:
                    raise ExceedsError(f"it has more than {MAX_CHUNK_MESSAGES} messages")
            elif opcode in {SCHEMA, CHANNEL}:
                declared.append(declaration(opcode, bytes(data[start : start + length])))
            position = start + length
    except (struct.error, UnicodeDecodeError) as error:
        raise DamagedError(f"its records cannot be read ({error})") from error
    return messages_at(data, np.array(places, np.int64)), declared


def rows_at(
    data: bytes | memoryview, places: npt.NDArray[np.int64], size: int
) -> npt.NDArray[np.uint8]:
    """Return `size` bytes from each of the places, copied: uint8 [m, size].

    Raises:
        IndexError: one of them reaches beyond the end.
    """
    if not places.size or not size:
        return np.zeros((len(places), size), np.uint8)
    # An item of that size at every byte: choosing among them copies each in one go, where a
    # place for every byte would be eight times the data.
    everywhere = np.ndarray((max(0, len(data) - size + 1),), f"V{size}", data, strides=(1,))
    return everywhere[places].view(np.uint8).reshape(len(places), size)


def messages_at(data: bytes | memoryview, places: npt.NDArray[np.int64]) -> Messages:
    """Return the messages that begin at the given places of a chunk.

    Raises:
        DamagedError: there is none at one of them.
    """
    body = MESSAGE_HEAD.size
    if places.size and (int(places.min()) < 0 or int(places.max()) > len(data) - body):
        raise DamagedError("a message is too short")
    heads = rows_at(data, places, body).view(_MESSAGE_DTYPE).reshape(-1)
    # Unsigned, so a length of 2**63 stays larger than the room.
    room = (len(data) - places - RECORD.size).astype(np.uint64)
    if (heads["opcode"] != MESSAGE).any():
        raise DamagedError("there is no message where one should be")
    if (heads["length"] < body - RECORD.size).any() or (heads["length"] > room).any():
        raise DamagedError("a message is too short")
    return Messages(
        heads["channel"].astype(np.uint16),
        heads["sequence"].astype(np.uint32),
        heads["log_time"].astype(np.uint64),
        places + body,
        heads["length"].astype(np.int64) - (body - RECORD.size),
    )
