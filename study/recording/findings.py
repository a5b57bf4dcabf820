"""What is in a recording file: noted, record by record, while the file is walked once."""

from __future__ import annotations

import dataclasses
import hashlib
import struct
from pathlib import Path

import numpy as np

from study.errors import RecordingError
from study.recording import mcap_walk
from study.recording.identity import (
    ATTACHMENT_DIGEST,
    FORMAT_VERSION,
    PROFILE,
    SELF_DIGEST,
    metadata_digest,
)
from study.recording.mcap_walk import DamagedError, Messages
from study.recording.wire import record_types_by_topic

MAX_RECORDS = 20_000_000
"""Most records that a recording may hold."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Where one chunk is, and what is in it.

    Attributes:
        start: place of its payload in the file, bytes.
        length: of the payload, bytes.
        messages: its messages.
    """

    start: int
    length: int
    messages: Messages


class Findings:
    """What a walk through a file has found so far.

    Args:
        path: the file, for messages.

    Attributes:
        problems: in words, what is missing or was left out.
        attachments: name to contents.
        channels: MCAP channel to topic.
        chunks: in file order.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.problems: list[str] = []
        self._profile = ""
        self._metadata: dict[str, str] | None = None
        self.attachments: dict[str, bytes] = {}
        self.channels: dict[int, str] = {}
        self.chunks: list[Chunk] = []
        self._records = 0
        self._last_sequence = -1

    def take(self, record: mcap_walk.TopLevel) -> None:
        """Note one record of the file.

        Raises:
            DamagedError: the record is damaged; those after it are left out.
        """
        try:
            if record.opcode == mcap_walk.HEADER:
                self._profile = mcap_walk.text_at(record.payload, 0)[0]
            elif record.opcode == mcap_walk.METADATA:
                name, entries = mcap_walk.metadata_record(record.payload)
                if name == PROFILE:
                    self._metadata = entries
                    self._check_version(entries)
            elif record.opcode == mcap_walk.ATTACHMENT:
                name, data = mcap_walk.attachment_record(record.payload)
                self.attachments[name] = data
        except (struct.error, UnicodeDecodeError) as error:
            raise DamagedError(f"the record at byte {record.start} is damaged: {error}") from error
        if record.opcode == mcap_walk.CHUNK:
            try:
                self._take_chunk(record)
            except DamagedError as error:
                raise DamagedError(
                    f"the chunk at byte {record.start} is damaged: {error}; "
                    "it and all after it are left out"
                ) from error

    def conclude(self) -> tuple[dict[str, str], bool]:
        """Return the metadata, and whether metadata and attachments are what they were.

        Raises:
            RecordingError: it is no recording of ours.
        """
        if self._profile != PROFILE or self._metadata is None:
            why = self.problems[0] if self.problems else "It was written by another program."
            raise RecordingError(
                f"{self._path} is no recording of this program: {why}",
                "Give the path of a recording (*.mcap), or of its unfinished .mcap.part.",
            )
        intact = self._check_digests(self._metadata)
        unknown = sorted(set(self.channels.values()) - set(record_types_by_topic()))
        if unknown:
            self.problems.append(f"Topics unknown to this program are left out: {unknown}.")
        return self._metadata, intact

    def _check_version(self, metadata: dict[str, str]) -> None:
        given = metadata.get("format_version", "")
        if given.isdecimal() and int(given) > FORMAT_VERSION:
            raise RecordingError(
                f"{self._path} has format version {given}; this program reads up to "
                f"{FORMAT_VERSION}",
                "Install a newer version of scaled-autonomy.",
            )
        if given != str(FORMAT_VERSION):
            raise RecordingError(f'{self._path} has an unknown format version "{given}"')

    def _take_chunk(self, record: mcap_walk.TopLevel) -> None:
        messages, channels = mcap_walk.chunk_messages(mcap_walk.chunk_data(record.payload))
        for number, topic in channels.items():
            if self.channels.setdefault(number, topic) != topic:
                raise DamagedError(f"channel {number} is declared twice")
        unknown = set(np.unique(messages.channel).tolist()) - set(self.channels)
        if unknown:
            raise DamagedError(f"messages are on undeclared channels {sorted(unknown)}")
        self._records += len(messages.sequence)
        if self._records > MAX_RECORDS:
            raise DamagedError(f"there are more than {MAX_RECORDS} records")
        steps = np.diff(messages.sequence.astype(np.int64), prepend=self._last_sequence)
        if (steps != 1).any():
            place = int(np.flatnonzero(steps != 1)[0])
            raise DamagedError(
                f"record {messages.sequence[place]} does not follow the one before it"
            )
        self.chunks.append(Chunk(record.start, len(record.payload), messages))
        if messages.sequence.size:
            self._last_sequence = int(messages.sequence[-1])

    def _check_digests(self, metadata: dict[str, str]) -> bool:
        """Hold metadata and attachments against their SHA-256; note and drop what differs."""
        before = len(self.problems)
        if metadata.get(SELF_DIGEST) != metadata_digest(metadata):
            self.problems.append("The metadata are damaged.")
        for key, digest in metadata.items():
            if not key.startswith(ATTACHMENT_DIGEST):
                continue
            name = key.removeprefix(ATTACHMENT_DIGEST)
            data = self.attachments.get(name)
            if data is None:
                self.problems.append(f'The attachment "{name}" is missing.')
            elif hashlib.sha256(data).hexdigest() != digest:
                self.problems.append(f'The attachment "{name}" is damaged and left out.')
                del self.attachments[name]
        return len(self.problems) == before
