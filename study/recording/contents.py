"""Opens a recording: by its index if it is whole, by a search for what is readable if not."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

from study.errors import RecordingError
from study.recording import mcap_records, stated
from study.recording.batches import batches
from study.recording.descriptors import descriptor_set, message_name
from study.recording.findings import (
    MAX_CHUNKS,
    MAX_RECORDS,
    Findings,
    FoundChunk,
    count_by_channel,
    gaps,
    ordered,
    runs,
    table,
)
from study.recording.identity import CHANNELS, SALVAGED_NUMBERS
from study.recording.losses import Loss, counts_text
from study.recording.mcap_index import ChunkTable
from study.recording.mcap_records import MAGIC, DamagedError, Declaration, ExceedsError
from study.recording.mcap_summary import (
    Summary,
    check_data_section,
    read_summary,
    states_checksum,
)
from study.recording.mcap_walk import record_at, walk
from study.recording.missing import missing_by_topic, missing_end
from study.recording.wire import record_types_by_topic

_PLACES_TOLD = 20
_AFTER_DATA = [bytes([code]) for code in (*b"\x02\x03\x04\x08\x0a\x0b\x0d\x0e", MAGIC[0])]
"""First bytes of what a summary consists of."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Contents:
    """What is readable of a file.

    Attributes:
        complete: whether nothing is missing, index and summary neither.
        problems: in words, what is missing or was left out.
        losses: the records that are missing.
        lost_by_topic: how many are missing by topic, as far as the summary tells.
        metadata: what the writer said.
        attachments: name to contents.
        declarations: schemas and channels.
        chunks: those readable, by sequence.
        numbers: sequence numbers held: first and last of each unbroken run.
        by_channel: number of records held, by channel.
        found: the chunks once more with what a walk found; empty if the index was used.
        unclosed: whether it breaks off before it was closed, and nothing else is wrong with it.
    """

    complete: bool
    problems: tuple[str, ...]
    losses: tuple[Loss, ...]
    lost_by_topic: dict[str, int]
    metadata: dict[str, str]
    attachments: dict[str, bytes]
    declarations: tuple[Declaration, ...]
    chunks: ChunkTable
    numbers: tuple[tuple[int, int], ...]
    by_channel: dict[int, int]
    found: tuple[FoundChunk, ...] = ()
    unclosed: bool = False

    @property
    def channels(self) -> dict[int, str]:
        """MCAP channel to topic."""
        return {
            item.number: item.topic
            for item in self.declarations
            if item.opcode == mcap_records.CHANNEL
        }

    @property
    def counts(self) -> dict[str, int]:
        """Topic to the number of its records held."""
        return {topic: self.by_channel.get(n, 0) for n, topic in self.channels.items()}


def read_contents(stream: BinaryIO, size: int, path: Path) -> Contents:
    """Open a file by its index if it is whole, else by `search_contents`.

    Raises:
        RecordingError: it is no recording of ours, was made by a newer version, or exceeds what
            any recording has.
    """
    try:
        return _by_index(stream, size, path)
    except ExceedsError as error:
        raise RecordingError(
            f"{path} is refused: {error}", "No recording of this program is like that."
        ) from error
    except DamagedError:
        return search_contents(stream, size, path)


def search_contents(stream: BinaryIO, size: int, path: Path) -> Contents:
    """Find everything readable in a file, whatever its state, and check all of it.

    Raises:
        RecordingError: as `read_contents`.
    """
    summary, intact = _checked_summary(stream)
    findings = Findings(path, intact=intact)
    last_damage, torn_to, exceeded = -1, size, ""
    where: list[str] = []
    stream.seek(0)
    if stream.read(len(MAGIC)) != MAGIC:
        findings.problems.append("It does not begin as an MCAP file.")
    try:
        for first, after, error in walk(stream, summary.start if summary else size, findings.take):
            if isinstance(error, ExceedsError):
                exceeded = exceeded or str(error)
            stream.seek(first)
            if findings.ended and stream.read(1) in _AFTER_DATA:
                # What follows the data is the summary, whose loss is told already.
                continue
            findings.ended = False
            where.append(_sentence(f"{error} (bytes {first} to {after - 1})."))
            last_damage, torn_to = first, after
    except ExceedsError as error:
        raise RecordingError(f"{path} is refused: {error}") from error
    if not findings.ours:
        if not path.stat().st_size:
            raise RecordingError(
                f"{path} is empty: it has 0 bytes", "Nothing was recorded in it: leave it out."
            )
        why = [*findings.problems, *where, "It was written by another program."][0]
        why = why[:1].lower() + why[1:]
        raise RecordingError(
            f"{path} is no recording of this program: {why}",
            "Give the path of a recording (*.mcap), or of its unfinished .mcap.part.",
        )
    if exceeded and (intact or not findings.chunks):
        raise RecordingError(
            f"{path} is refused: {exceeded}", "No recording of this program is like that."
        )
    if summary is None:
        findings.problems.append("Its summary and index are missing.")
    elif not intact and not where:
        findings.problems.append("The checksum of its data section is wrong.")
    findings.problems += where[:_PLACES_TOLD]
    if len(where) > _PLACES_TOLD:
        findings.problems.append(f"{len(where) - _PLACES_TOLD} more places are damaged.")
    findings.check_digests()
    _declare_the_lost(findings, summary)
    chunks = ordered(findings)
    losses = gaps(chunks, continues=findings.continues)
    missing = missing_by_topic(findings, summary, chunks)
    places = [chunk.start for chunk in chunks]
    # In a file whose blocks changed places, damage anywhere may have been its end.
    after_last = last_damage >= 0 and (last_damage > places[-1] if places else True)
    after_last |= places != sorted(places)
    if summary is None and findings.ended:
        findings.ended = states_checksum(stream, findings.end)
        after_last |= not findings.ended
    losses += missing_end(chunks, losses, findings, missing, damaged_end=after_last)
    losses += [loss for loss in stated.losses(findings.metadata) if loss not in losses]
    losses.sort(key=lambda loss: loss.first)
    findings.problems += stated.problems(findings.metadata)
    origin = chunks[0].first_ns if chunks else 0
    findings.problems += [loss.text(origin) for loss in losses]
    if missing:
        findings.problems.append(f"Missing in all: {counts_text(missing)}.")
    return Contents(
        complete=not losses and not findings.problems,
        problems=(*findings.problems, *_unknown_topics(findings)),
        losses=tuple(losses),
        lost_by_topic=missing or {},
        metadata=findings.metadata,
        attachments=findings.attachments,
        declarations=tuple(findings.declarations.values()),
        chunks=table(chunks),
        numbers=tuple(run for chunk in chunks for run in runs(chunk)),
        by_channel=dict(count_by_channel(chunks)),
        found=tuple(chunks),
        # Of what was damaged in its middle more is told: where, or what is missing there.
        unclosed=torn_to == size
        and _tells_only(findings, losses, others=len(where) + (summary is None)),
    )


def _by_index(stream: BinaryIO, size: int, path: Path) -> Contents:
    """Open a whole file of which only beginning and end are unpacked.

    Raises:
        DamagedError: it is not whole, or has no index.
    """
    summary = read_summary(stream)
    if summary is None:
        raise DamagedError("its summary and index are missing or cut off")
    if summary.message_count > MAX_RECORDS or len(summary.chunks) > MAX_CHUNKS:
        raise ExceedsError(f"there are more than {MAX_RECORDS} records or {MAX_CHUNKS} chunks")
    check_data_section(stream, summary)
    findings = Findings(path, intact=True)
    position = len(MAGIC)
    if not len(summary.chunks):
        raise DamagedError("it is to be searched")
    end = int(summary.chunks.start[0]) - mcap_records.RECORD.size
    while position < end:
        record = record_at(stream, position, size)
        findings.take(record)
        position = record.start + len(record.payload)
    if not findings.ours:
        raise DamagedError("it is to be searched")
    findings.check_digests()
    findings.declare(summary.declarations)
    if sum(summary.by_channel.values()) != summary.message_count:
        raise DamagedError("its summary contradicts itself")
    if not set(summary.by_channel) <= set(findings.channels):
        raise DamagedError("its channels are declared nowhere")
    losses = stated.losses(findings.metadata)
    numbers, origin = _stated_numbers(stream, summary, findings)
    if summary.message_count != sum(last - first + 1 for first, last in numbers):
        raise DamagedError("its numbers do not follow one another")
    findings.problems += [loss.text(origin) for loss in losses]
    lost = stated.by_topic(findings.metadata)
    findings.problems += stated.problems(findings.metadata)
    if lost:
        findings.problems.append(f"Missing in all: {counts_text(lost)}.")
    return Contents(
        complete=not findings.problems,
        problems=(*findings.problems, *_unknown_topics(findings)),
        losses=losses,
        lost_by_topic=lost,
        metadata=findings.metadata,
        attachments=findings.attachments,
        declarations=tuple(findings.declarations.values()),
        chunks=summary.chunks,
        numbers=numbers,
        by_channel=summary.by_channel,
        unclosed=_tells_only(findings, losses),
    )


def _checked_summary(stream: BinaryIO) -> tuple[Summary | None, bool]:
    """Return a file's summary if it is whole, and whether all data before it are."""
    try:
        summary = read_summary(stream)
    except ExceedsError:
        return None, False
    if summary is None:
        return None, False
    try:
        check_data_section(stream, summary)
    except DamagedError:
        return summary, False
    return summary, True


def _declare_the_lost(findings: Findings, summary: Summary | None) -> None:
    """Find the channels elsewhere if the chunk that declares them is damaged."""
    if findings.channels:
        return
    if summary is not None:
        findings.declare(summary.declarations)
        return
    topics = [str(topic) for topic in stated.json_value(findings.metadata, CHANNELS, [])]
    known = record_types_by_topic()
    for number, topic in enumerate(topics, start=1):
        if topic in known:
            schema = mcap_records.schema_payload(
                number, message_name(known[topic]), descriptor_set(topic)
            )
            channel = mcap_records.channel_payload(number, number, topic)
            findings.declare(
                [
                    Declaration(mcap_records.SCHEMA, number, schema),
                    Declaration(mcap_records.CHANNEL, number, channel),
                ]
            )


def _stated_numbers(
    stream: BinaryIO, summary: Summary, findings: Findings
) -> tuple[tuple[tuple[int, int], ...], int]:
    """Return the numbers that a whole file holds, and the log time of its first record."""
    first: list[int] = []
    origin = last = 0
    chunks, channels = summary.chunks, frozenset(summary.chunks.places)
    for chunk in (*chunks.each(slice(0, 3)), *chunks.each(slice(-1, None))):
        for batch in batches(stream, chunk, channels):
            origin = origin or int(batch.messages.log_time_ns[0])
            first += batch.messages.sequence[:2].tolist()
            last = int(batch.messages.sequence[-1])
    if SALVAGED_NUMBERS in findings.metadata:
        return stated.pairs(findings.metadata[SALVAGED_NUMBERS]), origin
    if not first:
        raise DamagedError("it is to be searched")
    begins = next((number for number in first if number), 0)
    if findings.continues and begins:
        return ((0, 0), (begins, last)), origin
    return ((0, last),), origin


def _tells_only(findings: Findings, losses: Sequence[Loss], others: int = 0) -> bool:
    """Return whether of what is wrong all but so much is that the end is missing."""
    told = len(findings.problems)
    only_end = len(losses) <= 1 and all(loss.last is None for loss in losses)
    known = told == len(losses) + others and not _unknown_topics(findings)
    return told > 0 and known and only_end


def _unknown_topics(findings: Findings) -> list[str]:
    unknown = sorted(set(findings.channels.values()) - set(record_types_by_topic()))
    return [f"Topics unknown to this program are left out: {unknown}."] if unknown else []


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:]
