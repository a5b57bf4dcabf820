"""Reads recordings, whole or damaged, in bounded memory and with every checksum verified.

A whole file is checked against the checksum of all its data and then read by its index: only
chunks that hold what is asked for are unpacked. A torn or damaged file is searched for every
chunk whose own checksum is right, before and after the damage; `Recording.losses` says which
records are missing, `Recording.problems` says it in words.
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
from study.recording.batches import Batch, batches, chunks_from
from study.recording.columns import ColumnBuilder
from study.recording.contents import read_contents
from study.recording.exported import export_of
from study.recording.identity import SALVAGED_FROM
from study.recording.losses import Loss
from study.recording.mcap_index import ChunkTable
from study.recording.mcap_records import DamagedError
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
        complete: whether the file is whole, with index and summary, and no record is missing.
        problems: in words, what is missing or was left out.
        losses: the records that are missing, in order.
        lost_by_topic: how many of them by topic, if the file still says so; else empty.
        metadata: what its writer said of it: format version, versions of libraries, ...
        attachments: name to contents: ``protocol.toml``.
        channels: MCAP channel to topic.
        chunks: those readable, in order of sequence.
        numbers: the sequence numbers held: first and last of each unbroken run.
        counts: topic to the number of its records.
        unclosed: whether it breaks off before it was closed, and nothing else is wrong with it.
    """

    path: Path
    complete: bool
    problems: tuple[str, ...]
    metadata: dict[str, str]
    attachments: dict[str, bytes]
    channels: dict[int, str] = dataclasses.field(repr=False)
    chunks: ChunkTable = dataclasses.field(repr=False)
    losses: tuple[Loss, ...] = ()
    lost_by_topic: dict[str, int] = dataclasses.field(default_factory=dict)
    numbers: tuple[tuple[int, int], ...] = dataclasses.field(default=(), repr=False)
    counts: dict[str, int] = dataclasses.field(default_factory=dict, repr=False)
    unclosed: bool = False

    @property
    def salvaged_from(self) -> str:
        """SHA-256 of the damaged file that this one was salvaged from; empty if it was not."""
        return self.metadata.get(SALVAGED_FROM, "")

    @cached_property
    def sequences(self) -> npt.NDArray[np.int64]:
        """Sequence numbers of all records, in order, without reading them."""
        runs = [np.arange(first, last + 1, dtype=np.int64) for first, last in self.numbers]
        return np.concatenate([np.zeros(0, np.int64), *runs])

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
            _check_topic(topic)
        for raw in self._select(set(topics or known)):
            yield raw.sequence, decode(raw.topic, raw.data)

    def raw(self, *families: Family, after: RawRecord | None = None) -> Iterator[RawRecord]:
        """Yield records undecoded, in order of sequence.

        Args:
            families: "input", "event", "shell"; all topics, unknown ones too, if none given.
            after: only those after this record, which is of these families; what comes well before
                it is not read.
        """
        topics = set(self.channels.values())
        if families:
            topics = {topic for topic in topics if topic.split("/")[0] in families}
        yield from self._select(topics, after)

    def find(self, topic: str, sequence: int, log_time_ns: int) -> RawRecord | None:
        """Return one record, reading little else; None if there is no such record.

        Args:
            topic: of the record.
            sequence: its number.
            log_time_ns: its log time.
        """
        wanted = RawRecord(sequence, topic, log_time_ns, b"")
        # Where the file's times do not lead to it, it is looked for from the beginning.
        for since in (wanted, None):
            for batch in self._batches({topic}, since):
                messages = batch.messages
                for place in np.flatnonzero(messages.sequence == sequence)[:1].tolist():
                    start = int(messages.start[place])
                    data = bytes(batch.data[start : start + int(messages.length[place])])
                    return RawRecord(sequence, topic, int(messages.log_time_ns[place]), data)
                if messages.sequence.size and int(messages.sequence[-1]) > sequence:
                    break
        return None

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
        _check_topic(topic)
        builder = ColumnBuilder(topic, self.counts.get(topic, 0))
        for batch in self._batches({topic}):
            _add(builder, batch)
        return builder.finish()

    def blocks(self, topic: str) -> Iterator[dict[str, npt.NDArray[Any]]]:
        """Yield a topic's records as `columns` does, in blocks of about half a MiB.

        For fleets of a thousand, whose columns would fill the memory.
        """
        _check_topic(topic)
        for batch in self._batches({topic}):
            builder = ColumnBuilder(topic)
            _add(builder, batch)
            yield from builder.finish()

    def _select(self, topics: set[str], after: RawRecord | None = None) -> Iterator[RawRecord]:
        for batch in self._batches(topics, after):
            messages = batch.messages
            if after is not None:
                if messages.sequence.size and messages.sequence[-1] < after.sequence:
                    continue
                place = np.flatnonzero(messages.sequence == after.sequence)
                if not place.size:
                    # The file's times do not lead to it: look for it from the beginning.
                    records = self._select(topics)
                    yield from (raw for raw in records if raw.sequence > after.sequence)
                    return
                messages, after = messages.chosen(slice(int(place[0]) + 1, None)), None
            for channel, sequence, log_time, start, length in zip(
                messages.channel.tolist(),
                messages.sequence.tolist(),
                messages.log_time_ns.tolist(),
                messages.start.tolist(),
                messages.length.tolist(),
                strict=True,
            ):
                payload = bytes(batch.data[start : start + length])
                yield RawRecord(sequence, self.channels[channel], log_time, payload)

    def _batches(self, topics: set[str], since: RawRecord | None = None) -> Iterator[Batch]:
        """Yield the messages of the given topics, in order of sequence.

        Of those before ``since`` only some are among them.
        """
        numbers = frozenset(n for n, topic in self.channels.items() if topic in topics)
        try:
            with self.path.open("rb") as stream:
                chunks = self.chunks
                if since is not None:
                    chunks = chunks_from(stream, chunks, since.log_time_ns)
                yield from batches(stream, chunks, numbers, soon=since is not None)
        except (DamagedError, OSError) as error:
            raise RecordingError(
                f"{self.path} cannot be read: {error}",
                "If it did not change meanwhile, salvage it with `study recover`.",
            ) from error


def read_recording(path: Path) -> Recording:
    """Open a recording, or what is left of one, and check all of it.

    Raises:
        RecordingError: there is no such file, it is no recording of ours, it exceeds what any
            recording has, or it was made by a newer version of this program.
    """
    if export := export_of(path):
        raise RecordingError(f"{path} is {export}, and no recording", "Give the recording itself.")
    try:
        size = path.stat().st_size
        with path.open("rb") as stream:
            contents = read_contents(stream, size, path)
    except FileNotFoundError as error:
        closed = path.with_suffix("")
        if path.suffix == ".part" and closed.exists():
            # Its session ended between the listing of its folder and now.
            return read_recording(closed)
        raise _unreadable(path, error) from error
    except OSError as error:
        raise _unreadable(path, error) from error
    return Recording(
        path=path,
        complete=contents.complete,
        problems=contents.problems,
        metadata=contents.metadata,
        attachments=contents.attachments,
        channels=contents.channels,
        chunks=contents.chunks,
        losses=contents.losses,
        lost_by_topic=contents.lost_by_topic,
        numbers=contents.numbers,
        counts=contents.counts,
        unclosed=contents.unclosed,
    )


def _unreadable(path: Path, error: OSError) -> RecordingError:
    return RecordingError(
        f"{path} cannot be read: {error.strerror}", "Give the path of a recording (*.mcap)."
    )


def _check_topic(topic: str) -> None:
    known = record_types_by_topic()
    if topic not in known:
        raise RecordingError(f'there is no topic "{topic}"', f"Known topics: {', '.join(known)}")


def _add(builder: ColumnBuilder, batch: Batch) -> None:
    messages = batch.messages
    builder.add(
        batch.data, messages.sequence, messages.log_time_ns, messages.start, messages.length
    )
