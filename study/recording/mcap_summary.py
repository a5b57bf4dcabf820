"""The summary at the end of a complete MCAP file: declarations, statistics, chunk index."""

from __future__ import annotations

import dataclasses
import os
import struct
import zlib
from typing import BinaryIO, Final

from study.recording.mcap_index import ChunkTable, index_table
from study.recording.mcap_records import (
    CHANNEL,
    CHUNK_INDEX,
    DATA_END,
    FOOTER,
    MAGIC,
    MAX_RECORD_BYTES,
    RECORD,
    SCHEMA,
    STATISTICS,
    DamagedError,
    Declaration,
    ExceedsError,
    TopLevel,
    declaration,
)

FOOTER_BYTES: Final = RECORD.size + 20 + len(MAGIC)
DATA_END_BYTES: Final = RECORD.size + 4
_STATISTICS = struct.Struct("<QHIIIIQQ")
_PAIR = struct.Struct("<HQ")
_CRC_BLOCK: Final = 2**18


@dataclasses.dataclass(frozen=True, slots=True)
class Summary:
    """A summary whose checksum is right.

    Attributes:
        start: where it begins, which is where the data section has ended, bytes.
        declarations: schemas and channels.
        chunks: the chunk index, in file order.
        message_count: messages in the file.
        by_channel: of them, by channel.
    """

    start: int
    declarations: tuple[Declaration, ...]
    chunks: ChunkTable
    message_count: int
    by_channel: dict[int, int]


def read_summary(stream: BinaryIO) -> Summary | None:
    """Return a file's summary; None if it has none that is whole.

    Raises:
        ExceedsError: it lists a chunk that is larger than any.
    """
    size = stream.seek(0, os.SEEK_END)
    if size < len(MAGIC) + FOOTER_BYTES:
        return None
    stream.seek(size - FOOTER_BYTES)
    footer = stream.read(FOOTER_BYTES)
    opcode, length = RECORD.unpack_from(footer)
    start, _, checksum = struct.unpack_from("<QQI", footer, RECORD.size)
    room = size - FOOTER_BYTES - start
    if opcode != FOOTER or length != 20 or footer[-len(MAGIC) :] != MAGIC:
        return None
    if start < len(MAGIC) + DATA_END_BYTES or not 0 <= room <= MAX_RECORD_BYTES:
        return None
    stream.seek(start)
    data = stream.read(room)
    if zlib.crc32(footer[: RECORD.size + 16], zlib.crc32(data)) != checksum:
        return None
    try:
        return _parse(data, start)
    except ExceedsError:
        raise
    except (struct.error, UnicodeDecodeError, DamagedError):
        return None


def check_data_section(stream: BinaryIO, summary: Summary) -> None:
    """Hold everything before the summary against its checksum.

    Raises:
        DamagedError: it has another checksum, or says none.
    """
    checksum = _checksum(stream, summary.start - DATA_END_BYTES)
    if checksum is None:
        raise DamagedError("it became shorter while it was read")
    opcode, length, said = struct.unpack("<BQI", stream.read(DATA_END_BYTES))
    if opcode != DATA_END or length != 4 or said != checksum:
        raise DamagedError("the checksum of its data section is wrong")


def states_checksum(stream: BinaryIO, end: TopLevel) -> bool:
    """Whether the record that ends the data states their checksum."""
    checksum = _checksum(stream, end.start - RECORD.size)
    return checksum is not None and end.payload == checksum.to_bytes(4, "little")


def _checksum(stream: BinaryIO, size: int) -> int | None:
    """Return the CRC-32 of a file's first bytes; None if it has not so many."""
    stream.seek(0)
    left, checksum = size, 0
    # One block's memory for all: new memory for each costs as much as the checksum.
    block = memoryview(bytearray(_CRC_BLOCK))
    while left > 0:
        count = stream.readinto(block[: min(left, _CRC_BLOCK)])  # type: ignore[attr-defined]
        if not count:
            return None
        checksum = zlib.crc32(block[:count], checksum)
        left -= count
    return checksum


def _parse(data: bytes, start: int) -> Summary:
    declarations: list[Declaration] = []
    at: list[int] = []
    lengths: list[int] = []
    count, by_channel = 0, dict[int, int]()
    position = 0
    while position < len(data):
        opcode, length = RECORD.unpack_from(data, position)
        position += RECORD.size
        if length > len(data) - position:
            raise DamagedError("a record of the summary is cut off")
        if opcode == CHUNK_INDEX:
            at.append(position)
            lengths.append(length)
        elif opcode in {SCHEMA, CHANNEL}:
            declarations.append(declaration(opcode, data[position : position + length]))
        elif opcode == STATISTICS:
            payload = data[position : position + length]
            count = _STATISTICS.unpack_from(payload)[0]
            by_channel = dict(_pairs(payload, _STATISTICS.size))
        position += length
    chunks = index_table(data, at, lengths, start)
    return Summary(start, tuple(declarations), chunks, count, by_channel)


def _pairs(payload: bytes, position: int) -> list[tuple[int, int]]:
    """Return a map from channel to a number: its length in bytes, then uint16 and uint64."""
    (length,) = struct.unpack_from("<I", payload, position)
    begin = position + 4
    if length % 10 or begin + length > len(payload):
        raise DamagedError("a map of the summary is malformed")
    return list(_PAIR.iter_unpack(payload[begin : begin + length]))
