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

MAGIC: Final = b"\x89MCAP0\r\n"
MAX_CHUNK_BYTES: Final = 48 * 2**20
"""Largest chunk accepted, compressed or not; the writer's have some 1 MiB and one record."""
MAX_RECORD_BYTES: Final = 64 * 2**20
"""Largest record accepted, attachments too."""

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06
MESSAGE_INDEX, CHUNK_INDEX, ATTACHMENT, STATISTICS = 0x07, 0x08, 0x09, 0x0B
METADATA, DATA_END = 0x0C, 0x0F

RECORD: Final = struct.Struct("<BQ")
_U32 = struct.Struct("<I")
_U64 = struct.Struct("<Q")


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


def declaration(opcode: int, payload: bytes) -> Declaration:
    """Return a schema or channel record, checked as far as it is used.

    Raises:
        struct.error: the record is malformed.
        UnicodeDecodeError: it holds no UTF-8.
    """
    (number,) = struct.unpack_from("<H", payload)
    text_at(payload, 4 if opcode == CHANNEL else 2)
    return Declaration(opcode, number, payload)


def text_at(data: bytes | memoryview, position: int) -> tuple[str, int]:
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
