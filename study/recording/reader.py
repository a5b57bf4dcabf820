"""Reads recordings, whole or torn, in bounded memory and with every checksum verified.

Opening a file walks it once and notes where each message is; the data are unpacked again,
chunk by chunk, when they are asked for. Of a file that is torn or damaged the part before
the damage is read, and `Recording.problems` says in words what is missing.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from study.errors import RecordingError
from study.events.fields import Family, Record
from study.recording import mcap_walk
from study.recording.columns import ColumnBuilder
from study.recording.findings import Chunk, Findings
from study.recording.mcap_walk import DamagedError, Messages
from study.recording.wire import decode, record_types_by_topic


@dataclasses.dataclass(frozen=True, slots=True)
class RawRecord:
    """One record as it is in the file.

    Attributes:
        sequence: its number over all topics, from 1; 0 is the writer's own opening note.
        topic: ``event/timestep``, ...
        log_time_ns: nanoseconds since 1970, UTC.
        data: the encoded record.
    """

    sequence: int
    topic: str
    log_time_ns: int
    data: bytes


@dataclasses.dataclass(frozen=True, eq=False)
class Recording:
    """One recording; made by `read_recording`.

    Attributes:
        path: the file.
        complete: whether the file is whole, with index and summary, and undamaged.
        problems: in words, what is missing or was left out.
        metadata: what its writer said of it: format version, versions of libraries, ...
        attachments: name to contents: ``protocol.toml``.
        channels: MCAP channel to topic.
        chunks: the chunks read, in file order.
    """

    path: Path
    complete: bool
    problems: tuple[str, ...]
    metadata: dict[str, str]
    attachments: dict[str, bytes]
    channels: dict[int, str] = dataclasses.field(repr=False)
    chunks: tuple[Chunk, ...] = dataclasses.field(repr=False)

    @cached_property
    def session_id(self) -> str:
        """Identifier of the session; empty if the file does not get as far as saying it."""
        if "session_id" in self.metadata:
            return self.metadata["session_id"]
        opened = next(self.records("input/session_opened"), None)
        return "" if opened is None else str(getattr(opened[1], "session_id", ""))

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the whole file, hexadecimal."""
        with self.path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()

    def records(self, *topics: str) -> Iterator[tuple[int, Record]]:
        """Yield (sequence, record) in order of sequence.

        Args:
            topics: which topics; all that this program knows if none are given.

        Raises:
            RecordingError: a topic is declared nowhere, or a record cannot be decoded.
        """
        known = record_types_by_topic()
        for topic in topics:
            if topic not in known:
                raise RecordingError(
                    f'there is no topic "{topic}"', f"Known topics: {', '.join(known)}"
                )
        for raw in self._select(set(topics or known)):
            yield raw.sequence, decode(raw.topic, raw.data)

    def raw(self, *families: Family) -> Iterator[RawRecord]:
        """Yield records undecoded, in order of sequence.

        Args:
            families: "input", "event", "shell"; all topics, unknown ones too, if none given.
        """
        topics = set(self.channels.values())
        if families:
            topics = {topic for topic in topics if topic.split("/")[0] in families}
        yield from self._select(topics)

    def columns(self, topic: str) -> list[dict[str, npt.NDArray[Any]]]:
        """Return a topic's records as arrays, without an object for each record.

        Args:
            topic: best one whose records hold numbers only, ``event/timestep`` for instance;
                others are decoded one by one, and text comes as arrays of objects.

        Returns:
            One dictionary for each run of records of one shape: field name to an array whose
            first axis is the record, plus ``sequence`` and ``log_time_ns``. A field of shape
            [n,d] becomes [rows, n, d].
        """
        if topic not in record_types_by_topic():
            raise RecordingError(
                f'there is no topic "{topic}"',
                f"Known topics: {', '.join(record_types_by_topic())}",
            )
        builder = ColumnBuilder(topic)
        for messages, chosen, data in self._unpack({topic}):
            builder.add(
                data,
                messages.sequence[chosen],
                messages.log_time_ns[chosen],
                messages.start[chosen],
                messages.length[chosen],
            )
        return builder.finish()

    def _select(self, topics: set[str]) -> Iterator[RawRecord]:
        for messages, chosen, data in self._unpack(topics):
            for channel, sequence, log_time, start, length in zip(
                messages.channel[chosen].tolist(),
                messages.sequence[chosen].tolist(),
                messages.log_time_ns[chosen].tolist(),
                messages.start[chosen].tolist(),
                messages.length[chosen].tolist(),
                strict=True,
            ):
                payload = data[start : start + length]
                yield RawRecord(sequence, self.channels[channel], log_time, payload)

    def _unpack(self, topics: set[str]) -> Iterator[tuple[Messages, npt.NDArray[np.intp], bytes]]:
        """Yield each chunk that holds one of the topics: which messages do, and its data."""
        numbers = [number for number, topic in self.channels.items() if topic in topics]
        with self.path.open("rb") as stream:
            for chunk in self.chunks:
                chosen = np.flatnonzero(np.isin(chunk.messages.channel, numbers))
                if not chosen.size:
                    continue
                stream.seek(chunk.start)
                try:
                    data = mcap_walk.chunk_data(stream.read(chunk.length))
                except DamagedError as error:
                    raise RecordingError(
                        f"{self.path} changed while it was read: {error}", "Read it again."
                    ) from error
                yield chunk.messages, chosen, data


def read_recording(path: Path) -> Recording:
    """Open a recording, or what is left of one, and check all of it.

    Raises:
        RecordingError: there is no such file, it is no recording of ours, or it was made by a
            newer version of this program.
    """
    try:
        size = path.stat().st_size
        with path.open("rb") as stream:
            found = Findings(path)
            try:
                for record in mcap_walk.walk(stream, size):
                    found.take(record)
                complete = True
            except DamagedError as error:
                found.problems.append(f"{path.name}: {error}.")
                complete = False
    except OSError as error:
        raise RecordingError(
            f"{path} cannot be read: {error.strerror}", "Give the path of a recording (*.mcap)."
        ) from error
    metadata, intact = found.conclude()
    return Recording(
        path=path,
        complete=complete and intact,
        problems=tuple(found.problems),
        metadata=metadata,
        attachments=found.attachments,
        channels=found.channels,
        chunks=tuple(found.chunks),
    )
