"""What is in a recording file: noted, record by record, while the file is walked once."""

from __future__ import annotations

import dataclasses
import hashlib
import struct
from collections import Counter
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from study.errors import RecordingError
from study.recording import mcap_records
from study.recording.identity import (
    ATTACHMENT_DIGEST,
    FORMAT_VERSION,
    PART,
    PROFILE,
    SELF_DIGEST,
    metadata_digest,
)
from study.recording.losses import Loss
from study.recording.mcap_chunks import chunk_data, chunk_messages
from study.recording.mcap_index import ChunkTable
from study.recording.mcap_records import DamagedError, Declaration, ExceedsError, TopLevel

MAX_RECORDS: Final = 5_000_000
"""Most records that a recording may hold: forty hours of twelve robots."""
MAX_CHUNKS: Final = 500_000
MAX_ATTACHMENTS_BYTES: Final = 96 * 2**20
"""Most bytes of all attachments together."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class FoundChunk:
    """A chunk whose checksum is right.

    Attributes:
        start: place of its payload in the file, bytes.
        length: of the payload, bytes.
        size: of its records once unpacked, bytes.
        sequence: numbers of its records, increasing, uint32 [m].
        first_ns: log time of its first record.
        last_ns: log time of its last record.
        by_channel: number of records by channel.
        checksum: of the packed chunk, to know a second copy by.
    """

    start: int
    length: int
    size: int
    sequence: npt.NDArray[np.uint32]
    first_ns: int
    last_ns: int
    by_channel: dict[int, int]
    checksum: bytes


class Findings:
    """What a walk through a file has found so far.

    Args:
        path: the file, for messages.
        intact: whether the checksum of all its data is right.

    Attributes:
        problems: in words, what is missing or was left out.
        attachments: name to contents.
        declarations: schemas and channels.
        chunks: in file order.
        ended: whether the end of the data was met, and no chunk after it.
        end: the record that ends the data, if it was met.
    """

    def __init__(self, path: Path, *, intact: bool = False) -> None:
        self._path = path
        self._intact = intact
        self.problems: list[str] = []
        self._profile = ""
        self._metadata: dict[str, str] | None = None
        self.attachments: dict[str, bytes] = {}
        self.declarations: dict[tuple[int, int], Declaration] = {}
        self.chunks: list[FoundChunk] = []
        self.ended = False
        self.end = TopLevel(mcap_records.DATA_END, 0, b"")
        self._records = 0

    @property
    def ours(self) -> bool:
        """Whether the file says that it is a recording of this program."""
        return self._profile == PROFILE or self._metadata is not None

    @property
    def metadata(self) -> dict[str, str]:
        """What the writer said; empty if that is lost."""
        return {} if self._metadata is None else self._metadata

    @property
    def continues(self) -> bool:
        """Whether the file is a later part, whose numbers do not begin at 1."""
        return self.metadata.get(PART, "1") != "1"

    @property
    def channels(self) -> dict[int, str]:
        """MCAP channel to topic."""
        return {
            number: item.topic
            for (opcode, number), item in self.declarations.items()
            if opcode == mcap_records.CHANNEL
        }

    def take(self, record: TopLevel) -> None:
        """Note one record of the file.

        Raises:
            DamagedError: the record is damaged.
            RecordingError: the file was made by a newer version of this program.
        """
        try:
            if record.opcode == mcap_records.HEADER:
                self._profile = self._profile or mcap_records.text_at(record.payload, 0)[0]
            elif record.opcode == mcap_records.METADATA:
                self._take_metadata(*mcap_records.metadata_record(record.payload))
            elif record.opcode == mcap_records.ATTACHMENT and not self.ended:
                self._take_attachment(*mcap_records.attachment_record(record.payload))
        except (struct.error, UnicodeDecodeError) as error:
            raise DamagedError(f"the record at byte {record.start} is damaged: {error}") from error
        if record.opcode == mcap_records.CHUNK:
            try:
                self._take_chunk(record)
            except DamagedError as error:
                text = f"the chunk at byte {record.start} is damaged: {error}"
                raise type(error)(text) from error
        elif record.opcode == mcap_records.DATA_END and len(record.payload) == 4:
            self.ended = True
            self.end = record

    def declare(self, items: tuple[Declaration, ...] | list[Declaration]) -> None:
        """Note schemas and channels.

        Raises:
            DamagedError: one contradicts an earlier one.
        """
        for item in items:
            if self.declarations.get((item.opcode, item.number), item) != item:
                raise DamagedError(f"channel or schema {item.number} is declared twice")
        self.declarations.update({(item.opcode, item.number): item for item in items})

    def check_digests(self) -> None:
        """Hold metadata and attachments against their SHA-256; note and drop what differs."""
        if self._metadata is None:
            self.problems.append("The metadata are damaged and left out.")
        for key, digest in self.metadata.items():
            if not key.startswith(ATTACHMENT_DIGEST):
                continue
            name = key.removeprefix(ATTACHMENT_DIGEST)
            data = self.attachments.get(name)
            if data is None:
                self.problems.append(f'The attachment "{name}" is missing.')
            elif hashlib.sha256(data).hexdigest() != digest:
                self.problems.append(f'The attachment "{name}" is damaged and left out.')
                del self.attachments[name]

    def _take_metadata(self, name: str, entries: dict[str, str]) -> None:
        if name != PROFILE:
            return
        proved = entries.get(SELF_DIGEST) == metadata_digest(entries)
        # What a damaged record says, even of its version, is not believed.
        if self._metadata is None and (proved or self._intact):
            self._check_version(entries)
            self._metadata = entries if proved else None

    def _check_version(self, entries: dict[str, str]) -> None:
        given = entries.get("format_version", "")
        if given.isdecimal() and int(given) > FORMAT_VERSION:
            raise RecordingError(
                f"{self._path} has format version {given}; this program reads up to "
                f"{FORMAT_VERSION}",
                "Install a newer version of scaled-autonomy: "
                "`pip install --upgrade scaled-autonomy`.",
            )
        if given != str(FORMAT_VERSION):
            raise RecordingError(
                f'{self._path} has an unknown format version "{given[:20]}"',
                "Give a recording that `study run` or `study simulate` made.",
            )

    def _take_attachment(self, name: str, data: bytes) -> None:
        size = sum(map(len, self.attachments.values())) + len(data)
        if size > MAX_ATTACHMENTS_BYTES:
            raise ExceedsError(f"the attachments have more than {MAX_ATTACHMENTS_BYTES} bytes")
        self.attachments.setdefault(name, data)

    def _take_chunk(self, record: TopLevel) -> None:
        data = chunk_data(record.payload)
        messages, declared = chunk_messages(data)
        if (np.diff(messages.sequence.astype(np.int64)) <= 0).any():
            raise DamagedError("its records are out of order")
        self._records += len(messages.sequence)
        if self._records > MAX_RECORDS:
            raise ExceedsError(f"there are more than {MAX_RECORDS} records")
        if len(self.chunks) >= MAX_CHUNKS:
            raise ExceedsError(f"there are more than {MAX_CHUNKS} chunks")
        self.declare(declared)
        if not messages.sequence.size:
            return
        self.ended = False
        channels, counts = np.unique(messages.channel, return_counts=True)
        by_channel = dict(zip(channels.tolist(), counts.tolist(), strict=True))
        self.chunks.append(
            FoundChunk(
                record.start,
                len(record.payload),
                len(data),
                messages.sequence,
                int(messages.log_time_ns[0]),
                int(messages.log_time_ns[-1]),
                by_channel,
                hashlib.sha256(record.payload).digest(),
            )
        )


def ordered(findings: Findings) -> list[FoundChunk]:
    """Return the chunks by sequence, each once; note in words what is left out."""
    chosen: list[FoundChunk] = []
    channels = set(findings.channels)
    left_out: Counter[str] = Counter()
    for chunk in sorted(findings.chunks, key=lambda item: int(item.sequence[0])):
        if not set(chunk.by_channel) <= channels:
            left_out["their channels are declared nowhere"] += 1
        elif not chosen or int(chosen[-1].sequence[-1]) < int(chunk.sequence[0]):
            chosen.append(chunk)
        elif chunk.checksum == chosen[-1].checksum:
            left_out["they are second copies"] += 1
        else:
            left_out["they contradict others"] += 1
    findings.problems += [f"{n} chunks are left out: {why}." for why, n in left_out.items()]
    return chosen


def gaps(chunks: list[FoundChunk], *, continues: bool) -> list[Loss]:
    """Return what is missing before and between chunks in order.

    Args:
        chunks: as `ordered` gives them.
        continues: whether the numbers after the opening note may begin anywhere.
    """
    losses: list[Loss] = []
    last, last_ns = -1, None
    for chunk in chunks:
        before = np.concatenate([[last], chunk.sequence[:-1].astype(np.int64)])
        for place in np.flatnonzero(chunk.sequence - before != 1).tolist():
            previous = int(before[place])
            if continues and previous <= 0:
                continue
            after_ns = last_ns if place == 0 else chunk.first_ns
            losses.append(
                Loss(previous + 1, int(chunk.sequence[place]) - 1, after_ns, chunk.first_ns)
            )
        last, last_ns = int(chunk.sequence[-1]), chunk.last_ns
    return losses


def count_by_channel(chunks: list[FoundChunk]) -> Counter[int]:
    """Return how many records chunks hold of each channel."""
    total: Counter[int] = Counter()
    for chunk in chunks:
        total.update(chunk.by_channel)
    return total


def table(chunks: list[FoundChunk]) -> ChunkTable:
    """Return where chunks are; their message indexes were not looked at."""
    rows = [(chunk.start, chunk.length, chunk.size) for chunk in chunks]
    start, length, size = np.array(rows, np.int64).reshape(-1, 3).T
    places = {
        channel: np.array([channel in chunk.by_channel for chunk in chunks], np.int64)
        for channel in count_by_channel(chunks)
    }
    return ChunkTable(start, length, size, start + length, places, indexed=False)


def runs(chunk: FoundChunk) -> list[tuple[int, int]]:
    """Return the unbroken runs of a chunk's numbers."""
    breaks = np.flatnonzero(np.diff(chunk.sequence) != 1) + 1
    parts = np.split(chunk.sequence, breaks)
    return [(int(part[0]), int(part[-1])) for part in parts]
