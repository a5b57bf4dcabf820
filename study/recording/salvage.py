"""Salvages a torn or damaged recording into a new, whole file; the original stays as it is.

Every chunk whose checksum is right is copied verbatim, in order of sequence; index and summary
are written anew. The new file's metadata say that it was salvaged, from what, and what is missing.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import struct
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np
import zstandard

from study.errors import RecordingError
from study.recording import mcap_records as records
from study.recording.contents import Contents, search_contents
from study.recording.durable_file import DurableFile
from study.recording.findings import FoundChunk
from study.recording.identity import (
    ATTACHMENT_DIGEST,
    FORMAT_VERSION,
    PROFILE,
    SALVAGED_BY_TOPIC,
    SALVAGED_FROM,
    SALVAGED_LOSSES,
    SALVAGED_NUMBERS,
    SALVAGED_PROBLEMS,
    SELF_DIGEST,
    metadata_digest,
)
from study.recording.losses import Loss, to_json
from study.recording.mcap_chunks import MESSAGE_HEAD, chunk_data, chunk_messages
from study.recording.mcap_records import RECORD, Declaration, text
from study.recording.opening import LIBRARY

_ATTACHMENT_INDEX, _METADATA_INDEX, _SUMMARY_OFFSET = 0x0A, 0x0D, 0x0E
_INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("place", "<u8")])


@dataclasses.dataclass(frozen=True, slots=True)
class Salvaged:
    """What salvaging a file gave.

    Attributes:
        path: the new file.
        sha256: of the original, hexadecimal.
        records: number of records salvaged.
        losses: records that are missing.
        lost_by_topic: how many of them by topic, if the original still said so; else empty.
        lost_content: in words, what else is lost: metadata, attachments.
        problems: in words, everything that was wrong with the original.
    """

    path: Path
    sha256: str
    records: int
    losses: tuple[Loss, ...]
    lost_by_topic: dict[str, int]
    lost_content: tuple[str, ...]
    problems: tuple[str, ...]

    @property
    def nothing_lost(self) -> bool:
        """Whether the new file holds all that the original ever held."""
        return not self.losses and not self.lost_content


def salvage(source: Path, target: Path) -> Salvaged:
    """Write what is readable of a recording into a new file.

    Args:
        source: the torn or damaged file; only read.
        target: the new file; it must not exist.

    Raises:
        RecordingError: the source is no recording of ours, or holds no record that can be read;
            or the target cannot be written.
    """
    try:
        size = source.stat().st_size
        stream = source.open("rb")
    except OSError as error:
        raise RecordingError(
            f"{source} cannot be read: {error.strerror}", "Give the path of a recording (*.mcap)."
        ) from error
    with stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
        contents = search_contents(stream, size, source)
        if not contents.numbers:
            raise RecordingError(
                f"{source} holds no record that can be read: there is nothing to salvage",
                "It stays as it is, and no file is written. What was wrong: "
                f"{' '.join(contents.problems[:3])}",
            )
        try:
            path = _write(stream, contents, digest, target)
        except FileExistsError as error:
            raise RecordingError(
                f"{error.filename} exists already", "Choose another name with --output."
            ) from error
        except OSError as error:
            raise RecordingError(f"{target} cannot be written: {error.strerror}") from error
    return Salvaged(
        path=path,
        sha256=digest,
        records=sum(last - first + 1 for first, last in contents.numbers),
        losses=contents.losses,
        lost_by_topic=contents.lost_by_topic,
        lost_content=_lost_content(contents),
        problems=contents.problems,
    )


def _lost_content(contents: Contents) -> tuple[str, ...]:
    starts = ("The metadata ", "The attachment ")
    return tuple(problem for problem in contents.problems if problem.startswith(starts))


def _write(stream: BinaryIO, contents: Contents, digest: str, target: Path) -> Path:
    file = DurableFile(target)
    try:
        return _fill(file, stream, contents, digest)
    except OSError as error:
        if not isinstance(error, FileExistsError):
            # What is half there would be in the way of the next try.
            file.discard()
        raise


def _fill(file: DurableFile, stream: BinaryIO, contents: Contents, digest: str) -> Path:
    out = _McapFile(file)
    out.record(records.HEADER, text(PROFILE) + text(LIBRARY))
    out.metadata(_metadata(contents, digest))
    for name, data in contents.attachments.items():
        out.attachment(name, data)
    out.declare(contents.declarations)
    for chunk in contents.found:
        stream.seek(chunk.start)
        out.chunk(stream.read(chunk.length), chunk)
    out.finish()
    return file.publish()


def _metadata(contents: Contents, digest: str) -> dict[str, str]:
    # Attachments that are lost are no longer promised.
    kept = {
        key: value
        for key, value in contents.metadata.items()
        if key != SELF_DIGEST
        and (
            not key.startswith(ATTACHMENT_DIGEST)
            or key.removeprefix(ATTACHMENT_DIGEST) in contents.attachments
        )
    }
    entries = {
        **kept,
        "format_version": str(FORMAT_VERSION),
        SALVAGED_FROM: digest,
        SALVAGED_LOSSES: to_json(contents.losses),
        SALVAGED_BY_TOPIC: json.dumps(contents.lost_by_topic),
        SALVAGED_PROBLEMS: json.dumps(_lost_content(contents)),
        SALVAGED_NUMBERS: json.dumps(contents.numbers),
    }
    return {**entries, SELF_DIGEST: metadata_digest(entries)}


class _McapFile:
    """Writes an MCAP file of chunks that are packed already; mcap's own Writer packs anew."""

    def __init__(self, file: DurableFile) -> None:
        self._file = file
        self._checksum = 0
        self._counts: dict[int, int] = {}
        self._declared: tuple[Declaration, ...] = ()
        self._indexes: dict[int, list[bytes]] = {}
        self._times: list[int] = []
        self._put(records.MAGIC)

    def record(self, opcode: int, payload: bytes) -> tuple[int, int]:
        """Write one record; return where it begins and its length, bytes."""
        place = self._file.tell()
        self._put(RECORD.pack(opcode, len(payload)) + payload)
        return place, RECORD.size + len(payload)

    def metadata(self, entries: dict[str, str]) -> None:
        """Write our metadata record."""
        packed = b"".join(text(key) + text(value) for key, value in entries.items())
        payload = text(PROFILE) + struct.pack("<I", len(packed)) + packed
        where = self.record(records.METADATA, payload)
        self._index(_METADATA_INDEX, struct.pack("<QQ", *where) + text(PROFILE))

    def attachment(self, name: str, data: bytes) -> None:
        """Write one attachment."""
        kind = "application/octet-stream"
        body = bytes(16) + text(name) + text(kind) + struct.pack("<Q", len(data)) + data
        where = self.record(records.ATTACHMENT, body + struct.pack("<I", zlib.crc32(body)))
        index = struct.pack("<QQQQQ", *where, 0, 0, len(data)) + text(name) + text(kind)
        self._index(_ATTACHMENT_INDEX, index)

    def declare(self, declarations: tuple[Declaration, ...]) -> None:
        """Write schemas and channels as a chunk of their own, which a checksum protects."""
        # Schemas first: channels refer to them.
        self._declared = tuple(sorted(declarations, key=lambda item: (item.opcode, item.number)))
        data = b"".join(_framed(item.opcode, item.payload) for item in self._declared)
        packed = zstandard.compress(data)
        head = struct.pack("<QQQI", 0, 0, len(data), zlib.crc32(data))
        payload = head + text("zstd") + struct.pack("<Q", len(packed)) + packed
        self._chunk_index(self.record(records.CHUNK, payload), payload, {}, 0)

    def chunk(self, payload: bytes, found: FoundChunk) -> None:
        """Write a chunk verbatim, and its message indexes anew."""
        messages, _ = chunk_messages(chunk_data(payload))
        where = self.record(records.CHUNK, payload)
        places: dict[int, int] = {}
        begin = self._file.tell()
        for channel, count in found.by_channel.items():
            chosen = messages.channel == channel
            entries = np.zeros(count, _INDEX_ENTRY)
            entries["log_time"] = messages.log_time_ns[chosen]
            entries["place"] = messages.start[chosen] - MESSAGE_HEAD.size
            index = struct.pack("<HI", channel, entries.nbytes) + entries.tobytes()
            places[channel] = self.record(records.MESSAGE_INDEX, index)[0]
            self._counts[channel] = self._counts.get(channel, 0) + count
        self._times += [int(messages.log_time_ns.min()), int(messages.log_time_ns.max())]
        self._chunk_index(where, payload, places, self._file.tell() - begin)

    def finish(self) -> None:
        """Write the end of the data, the summary and the footer."""
        self.record(records.DATA_END, struct.pack("<I", self._checksum))
        start = self._file.tell()
        groups: dict[int, list[bytes]] = {records.SCHEMA: [], records.CHANNEL: []}
        for item in self._declared:
            groups[item.opcode].append(_framed(item.opcode, item.payload))
        groups[records.STATISTICS] = [_framed(records.STATISTICS, self._statistics(groups))]
        groups |= self._indexes
        summary = b""
        offsets = b""
        for opcode, members in groups.items():
            group = b"".join(members)
            if group:
                where = struct.pack("<BQQ", opcode, start + len(summary), len(group))
                offsets += _framed(_SUMMARY_OFFSET, where)
            summary += group
        offsets_start = start + len(summary)
        summary += offsets
        footer = RECORD.pack(records.FOOTER, 20) + struct.pack("<QQ", start, offsets_start)
        checksum = zlib.crc32(footer, zlib.crc32(summary))
        self._put(summary + footer + struct.pack("<I", checksum) + records.MAGIC)

    def _statistics(self, groups: dict[int, list[bytes]]) -> bytes:
        counts = b"".join(struct.pack("<HQ", *item) for item in self._counts.items())
        fixed = struct.pack(
            "<QHIIIIQQ",
            sum(self._counts.values()),
            len(groups[records.SCHEMA]),
            len(groups[records.CHANNEL]),
            len(self._indexes.get(_ATTACHMENT_INDEX, ())),
            len(self._indexes.get(_METADATA_INDEX, ())),
            len(self._indexes.get(records.CHUNK_INDEX, ())),
            min(self._times, default=0),
            max(self._times, default=0),
        )
        return fixed + struct.pack("<I", len(counts)) + counts

    def _chunk_index(
        self, where: tuple[int, int], payload: bytes, places: dict[int, int], length: int
    ) -> None:
        first, last, size, _ = struct.unpack_from("<QQQI", payload)
        compression, position = records.text_at(payload, struct.calcsize("<QQQI"))
        packed = len(payload) - position - 8
        pairs = b"".join(struct.pack("<HQ", *item) for item in places.items())
        index = struct.pack("<QQQQI", first, last, *where, len(pairs)) + pairs
        index += struct.pack("<Q", length) + text(compression) + struct.pack("<QQ", packed, size)
        self._index(records.CHUNK_INDEX, index)

    def _index(self, opcode: int, payload: bytes) -> None:
        self._indexes.setdefault(opcode, []).append(_framed(opcode, payload))

    def _put(self, data: bytes) -> None:
        self._checksum = zlib.crc32(data, self._checksum)
        self._file.write(data)


def _framed(opcode: int, payload: bytes) -> bytes:
    return RECORD.pack(opcode, len(payload)) + payload
