"""The records of an MCAP file, taken apart without trusting anything in them.

Only what our own writer produces is understood: zstd or uncompressed chunks, checksums
everywhere. Every length is held against the bytes there are before anything is allocated, so
neither a torn nor a hostile file can exhaust memory.
"""

from __future__ import annotations

import dataclasses
import struct
import zlib
from typing import Final

import numpy as np
import numpy.typing as npt
import zstandard

MAGIC: Final = b"\x89MCAP0\r\n"
MAX_CHUNK_BYTES: Final = 48 * 2**20
"""Largest chunk accepted, compressed or not; the writer's have some 1 MiB and one record."""
MAX_RECORD_BYTES: Final = 64 * 2**20
"""Largest record accepted, attachments too."""
MAX_CHUNK_MESSAGES: Final = 100_000

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06
MESSAGE_INDEX, CHUNK_INDEX, ATTACHMENT, STATISTICS = 0x07, 0x08, 0x09, 0x0B
METADATA, DATA_END = 0x0C, 0x0F

RECORD: Final = struct.Struct("<BQ")
MESSAGE_HEAD: Final = struct.Struct("<BQHIQQ")
_CHUNK = struct.Struct("<QQQI")
_U32 = struct.Struct("<I")
_U64 = struct.Struct("<Q")
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


class DamagedError(Exception):
    """The file ends early or is not what its checksums say; the text says where."""


class ExceedsError(DamagedError):
    """A part of the file is larger than any recording's: a declared limit is exceeded."""


@dataclasses.dataclass(frozen=True, slots=True)
class TopLevel:
    """One record of the file outside any chunk.

    Attributes:
        opcode: which kind of record.
        start: place of the payload in the file, bytes.
        payload: the record without opcode and length.
    """

    opcode: int
    start: int
    payload: bytes


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


@dataclasses.dataclass(frozen=True, slots=True)
class Declaration:
    """A schema or a channel, as it is in the file.

    Attributes:
        opcode: SCHEMA or CHANNEL.
        number: of the schema or the channel.
        payload: the record without opcode and length.
    """

    opcode: int
    number: int
    payload: bytes

    @property
    def topic(self) -> str:
        """A channel's topic."""
        return text_at(self.payload, 4)[0]


def chunk_size(payload: bytes) -> int:
    """Return how many bytes a chunk's records have once unpacked.

    Args:
        payload: the chunk, or its first 32 bytes.

    Raises:
        DamagedError: the chunk is cut off.
        ExceedsError: they would be too many.
    """
    if len(payload) < _CHUNK.size:
        raise DamagedError("it is cut off")
    size: int = _CHUNK.unpack_from(payload)[2]
    if size > MAX_CHUNK_BYTES:
        raise ExceedsError(f"it would have {size} bytes, more than {MAX_CHUNK_BYTES}")
    return size


def chunk_data(payload: bytes, unpacker: zstandard.ZstdDecompressor | None = None) -> bytes:
    """Return a chunk's records, uncompressed and checked.

    Args:
        payload: the chunk, without opcode and length.
        unpacker: to be used again from chunk to chunk; not by two threads at once.

    Raises:
        DamagedError: the chunk is not what its checksum says, or too large.
    """
    try:
        size = chunk_size(payload)
        checksum = _CHUNK.unpack_from(payload)[3]
        compression, position = text_at(payload, _CHUNK.size)
        (length,) = _U64.unpack_from(payload, position)
        packed = memoryview(payload)[position + _U64.size :]
        if length != len(packed):
            raise DamagedError("its length is wrong")
        if compression == "zstd":
            unpacker = unpacker or zstandard.ZstdDecompressor()
            # The frame's own statement decides how much is allocated.
            if zstandard.get_frame_parameters(packed).content_size != size:
                raise DamagedError("its sizes contradict each other")
            data: bytes = unpacker.decompress(packed, max_output_size=size)
        elif compression == "":
            data = bytes(packed)
        else:
            raise DamagedError(f'its compression "{compression[:20]}" is not supported')
    except (struct.error, UnicodeDecodeError, zstandard.ZstdError, MemoryError) as error:
        raise DamagedError(f"it cannot be unpacked ({error})") from error
    if len(data) != size or zlib.crc32(data) != checksum:
        raise DamagedError("its checksum is wrong")
    return data


def chunk_messages(data: bytes) -> tuple[Messages, list[Declaration]]:
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
                declared.append(declaration(opcode, data[start : start + length]))
            position = start + length
    except (struct.error, UnicodeDecodeError) as error:
        raise DamagedError(f"its records cannot be read ({error})") from error
    return messages_at(data, np.array(places, np.int64)), declared


def rows_at(data: bytes, places: npt.NDArray[np.int64], size: int) -> npt.NDArray[np.uint8]:
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


def messages_at(data: bytes, places: npt.NDArray[np.int64]) -> Messages:
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


def declaration(opcode: int, payload: bytes) -> Declaration:
    """Return a schema or channel record, checked as far as it is used.

    Raises:
        struct.error: the record is malformed.
        UnicodeDecodeError: it holds no UTF-8.
    """
    (number,) = struct.unpack_from("<H", payload)
    text_at(payload, 4 if opcode == CHANNEL else 2)
    return Declaration(opcode, number, payload)


def text_at(data: bytes, position: int) -> tuple[str, int]:
    """Return the length-prefixed text at a place, and the place after it.

    Raises:
        struct.error: the text reaches beyond the end.
        UnicodeDecodeError: it is no UTF-8.
    """
    (length,) = _U32.unpack_from(data, position)
    end = position + _U32.size + length
    if end > len(data):
        raise struct.error("text reaches beyond the end")
    return str(data[position + _U32.size : end], "utf-8"), end


def text(value: str) -> bytes:
    """Return length-prefixed text."""
    data = value.encode()
    return _U32.pack(len(data)) + data


def schema_payload(number: int, name: str, descriptor: bytes) -> bytes:
    """Return a schema record of protobuf, without opcode and length."""
    content = _U32.pack(len(descriptor)) + descriptor
    return struct.pack("<H", number) + text(name) + text("protobuf") + content


def channel_payload(number: int, schema: int, topic: str) -> bytes:
    """Return a channel record of protobuf, without opcode and length."""
    return struct.pack("<HH", number, schema) + text(topic) + text("protobuf") + _U32.pack(0)


def metadata_record(payload: bytes) -> tuple[str, dict[str, str]]:
    """Return the name and the entries of a metadata record.

    Raises:
        struct.error: the record is malformed.
        UnicodeDecodeError: it holds no UTF-8.
    """
    name, position = text_at(payload, 0)
    position += _U32.size
    entries = {}
    while position < len(payload):
        key, position = text_at(payload, position)
        entries[key], position = text_at(payload, position)
    return name, entries


def attachment_record(payload: bytes) -> tuple[str, bytes]:
    """Return the name and the contents of an attachment, checked.

    Raises:
        struct.error: the record is malformed, or its checksum is wrong.
        UnicodeDecodeError: its name is no UTF-8.
    """
    name, position = text_at(payload, 16)
    _, position = text_at(payload, position)
    (length,) = _U64.unpack_from(payload, position)
    start = position + _U64.size
    if start + length + _U32.size != len(payload):
        raise struct.error("the length is wrong")
    if _U32.unpack_from(payload, start + length)[0] != zlib.crc32(payload[: start + length]):
        raise struct.error("the checksum is wrong")
    return name, payload[start : start + length]
