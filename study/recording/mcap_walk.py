"""Walks an MCAP file in file order, trusting nothing: lengths, counts and checksums first.

Only what our own writer produces is understood: zstd or uncompressed chunks, checksums
everywhere. Every length is held against the bytes there are before anything is allocated, so
neither a torn nor a hostile file can exhaust memory.
"""

from __future__ import annotations

import dataclasses
import struct
import zlib
from collections.abc import Iterator
from typing import BinaryIO, Final

import numpy as np
import numpy.typing as npt
import zstandard

MAGIC: Final = b"\x89MCAP0\r\n"
MAX_CHUNK_BYTES: Final = 256 * 2**20
"""Largest chunk accepted, compressed or not."""
MAX_RECORD_BYTES: Final = 256 * 2**20
"""Largest record accepted."""
MAX_CHUNK_MESSAGES: Final = 1_000_000
MAX_TOP_LEVEL_RECORDS: Final = 2_000_000

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06
ATTACHMENT, METADATA, DATA_END = 0x09, 0x0C, 0x0F

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<BQHIQQ")
_CHUNK = struct.Struct("<QQQI")
_U32 = struct.Struct("<I")
_U64 = struct.Struct("<Q")
_FOOTER_AND_MAGIC: Final = _RECORD.size + 20 + len(MAGIC)


class DamagedError(Exception):
    """The file ends early or is not what its checksums say; the text says where."""


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
    """The messages of one chunk, without their data.

    Attributes:
        channel: uint16 [m].
        sequence: uint32 [m].
        log_time_ns: uint64 [m].
        start: place of the data in the uncompressed chunk, int64 [m].
        length: of the data, bytes, int64 [m].
    """

    channel: npt.NDArray[np.uint16]
    sequence: npt.NDArray[np.uint32]
    log_time_ns: npt.NDArray[np.uint64]
    start: npt.NDArray[np.int64]
    length: npt.NDArray[np.int64]


def walk(stream: BinaryIO, size: int) -> Iterator[TopLevel]:
    """Yield the records up to the end of the data section, then check the rest.

    Args:
        stream: the file, at its beginning.
        size: its length, bytes.

    Raises:
        DamagedError: after the last record that is whole.
    """
    magic = stream.read(len(MAGIC))
    if magic != MAGIC:
        raise DamagedError("it does not begin as an MCAP file")
    checksum = zlib.crc32(magic)
    position = len(MAGIC)
    for _ in range(MAX_TOP_LEVEL_RECORDS):
        head = stream.read(_RECORD.size)
        if not head:
            raise DamagedError(f"it breaks off after {position} bytes, without an index")
        if len(head) < _RECORD.size:
            raise DamagedError(f"it breaks off in the record at byte {position}")
        opcode, length = _RECORD.unpack(head)
        start = position + _RECORD.size
        if length > size - start:
            raise DamagedError(f"it breaks off in the record at byte {position}")
        if length > MAX_RECORD_BYTES:
            raise DamagedError(f"the record at byte {position} has {length} bytes: too many")
        payload = stream.read(length)
        if len(payload) < length:
            raise DamagedError(f"it breaks off in the record at byte {position}")
        if opcode == DATA_END:
            _check_end(stream, payload, checksum, start + length, size)
            return
        checksum = zlib.crc32(payload, zlib.crc32(head, checksum))
        yield TopLevel(opcode, start, payload)
        position = start + length
    raise DamagedError(f"it has more than {MAX_TOP_LEVEL_RECORDS} records")


def chunk_data(payload: bytes) -> bytes:
    """Return a chunk's records, uncompressed and checked.

    Raises:
        DamagedError: the chunk is not what its checksum says, or too large.
    """
    try:
        _, _, size, checksum = _CHUNK.unpack_from(payload)
        compression, position = text_at(payload, _CHUNK.size)
        (length,) = _U64.unpack_from(payload, position)
        packed = memoryview(payload)[position + _U64.size :]
        if length != len(packed):
            raise DamagedError("its length is wrong")
        if size > MAX_CHUNK_BYTES:
            raise DamagedError(f"it would have {size} bytes, more than {MAX_CHUNK_BYTES}")
        if compression == "zstd":
            # The frame's own statement decides how much is allocated.
            if zstandard.get_frame_parameters(packed).content_size != size:
                raise DamagedError("its sizes contradict each other")
            data: bytes = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        elif compression == "":
            data = bytes(packed)
        else:
            raise DamagedError(f'its compression "{compression[:20]}" is not supported')
    except (struct.error, UnicodeDecodeError, zstandard.ZstdError, MemoryError) as error:
        raise DamagedError(f"it cannot be unpacked ({error})") from error
    if len(data) != size or zlib.crc32(data) != checksum:
        raise DamagedError("its checksum is wrong")
    return data


def chunk_messages(data: bytes) -> tuple[Messages, dict[int, str]]:
    """Return where a chunk's messages are, and the channels it declares: number to topic.

    Raises:
        DamagedError: the records do not fill the chunk, or are too many.
    """
    found: list[tuple[int, int, int, int, int]] = []
    channels: dict[int, str] = {}
    position, size = 0, len(data)
    body = _MESSAGE.size - _RECORD.size
    try:
        while position < size:
            opcode, length = _RECORD.unpack_from(data, position)
            start = position + _RECORD.size
            if length > size - start:
                raise DamagedError("a record reaches beyond its end")
            if opcode == MESSAGE:
                _, _, channel, sequence, log_time, _ = _MESSAGE.unpack_from(data, position)
                if length < body:
                    raise DamagedError("a message is too short")
                found.append((channel, sequence, log_time, start + body, length - body))
                if len(found) > MAX_CHUNK_MESSAGES:
                    raise DamagedError(f"it has more than {MAX_CHUNK_MESSAGES} messages")
            elif opcode == CHANNEL:
                (number,) = struct.unpack_from("<H", data, start)
                channels[number] = text_at(data, start + 4)[0]
            position = start + length
    except (struct.error, UnicodeDecodeError) as error:
        raise DamagedError(f"its records cannot be read ({error})") from error
    columns = list(zip(*found, strict=True)) or [()] * 5
    return (
        Messages(
            np.array(columns[0], np.uint16),
            np.array(columns[1], np.uint32),
            np.array(columns[2], np.uint64),
            np.array(columns[3], np.int64),
            np.array(columns[4], np.int64),
        ),
        channels,
    )


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


def _check_end(stream: BinaryIO, data_end: bytes, checksum: int, start: int, size: int) -> None:
    """Check the data section's checksum, and the summary that starts at byte `start`."""
    if data_end != _U32.pack(checksum):
        raise DamagedError("the checksum of its data section is wrong")
    if not _FOOTER_AND_MAGIC <= size - start <= MAX_RECORD_BYTES:
        raise DamagedError("its summary and index are missing or cut off")
    rest = stream.read(size - start)
    opcode, length = _RECORD.unpack_from(rest, len(rest) - _FOOTER_AND_MAGIC)
    summary_start, _, summary_checksum = struct.unpack_from(
        "<QQI", rest, len(rest) - _FOOTER_AND_MAGIC + _RECORD.size
    )
    if rest[-len(MAGIC) :] != MAGIC or opcode != FOOTER or length != 20 or summary_start != start:
        raise DamagedError("its summary and index are missing or cut off")
    if zlib.crc32(rest[: -len(MAGIC) - _U32.size]) != summary_checksum:
        raise DamagedError("the checksum of its summary is wrong")
