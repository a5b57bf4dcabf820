"""A session's parts, read as one recording.

A session is recorded in one file, unless its writer failed or the study was resumed: then
numbered parts follow it. Sequence numbers run through all of them. A part begun after the
writer failed repeats what was not known to be on disk; of such duplicates the first counts.
A part begun by a resume goes back to a boundary: what earlier parts hold after it is left out.
"""

from __future__ import annotations

import dataclasses
import hashlib
import re
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from study.errors import RecordingError
from study.events.events import TrialStarted
from study.events.fields import Family, Record
from study.events.inputs import SessionResumed
from study.recording.identity import PART
from study.recording.losses import Loss
from study.recording.reader import RawRecord, Recording, read_recording
from study.recording.spans import ALL, Span, disagreements, gaps, within

SALVAGED = "_salvaged"
_FILE_NAME = re.compile(
    rf"(?P<name>.+?)(?:_part(?P<part>[1-9][0-9]{{0,5}}))?(?P<copy>{SALVAGED})?\.mcap(\.part)?"
)


@dataclasses.dataclass(frozen=True, eq=False)
class SessionRecording:
    """All parts of one session, with the interface of a `Recording`; made by `join_parts`.

    Attributes:
        parts: the files, in order; at least one.
        spans: what each part adds to those before it.
        left_out: spans recorded between a boundary and the resume that went back to it.
        losses: records of the session that are in no part, in order.
        faults: in words, where the parts do not fit together.
    """

    parts: tuple[Recording, ...]
    spans: tuple[Span, ...] = dataclasses.field(repr=False)
    left_out: tuple[Span, ...] = dataclasses.field(repr=False)
    losses: tuple[Loss, ...] = ()
    faults: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        """The file of the first part."""
        return self.parts[0].path

    @property
    def session_id(self) -> str:
        """Identifier of the session."""
        return self.parts[0].session_id

    @property
    def without_first(self) -> str:
        """Which first part is not among the files, in words; empty if it is."""
        if part_number(self.parts[0]) == 1:
            return ""
        first = f"{base_name(self.path)}.mcap"
        return f"{self.path.name} is a later part, and part 1 is not beside it: {first}"

    @property
    def metadata(self) -> dict[str, str]:
        """What the writer of the first part said of it."""
        return self.parts[0].metadata

    @property
    def attachments(self) -> dict[str, bytes]:
        """Name to contents, of the first part."""
        return self.parts[0].attachments

    @property
    def complete(self) -> bool:
        """Whether no record that belongs to the session is missing, and the last file is whole.

        An earlier part may be torn where a later one makes up for it.
        """
        return not self.faults and self.parts[-1].complete

    @property
    def problems(self) -> tuple[str, ...]:
        """In words, what is missing, was left out or does not fit together; of several, where."""
        parts = [part for part in self.parts if part not in self._made_up_for]
        told = ((f"Part {part_number(p)}: " if self.parts[1:] else "", p) for p in parts)
        return (*(lead + problem for lead, p in told for problem in p.problems), *self.faults)

    @property
    def remarks(self) -> tuple[str, ...]:
        """In words, what is no problem but wants an explanation: files that were not closed."""
        return tuple(
            f"Part {part_number(part)} was not closed; part {number} goes on from record {first}: "
            "nothing is missing."
            for part in self._made_up_for
            for number, first in [self._after(part)]
        )

    @property
    def _made_up_for(self) -> tuple[Recording, ...]:
        """The parts that break off, and nothing that belongs to the session is missing for it."""
        return () if self.faults else tuple(part for part in self.parts[:-1] if part.unclosed)

    def _after(self, part: Recording) -> tuple[int, int]:
        """Return which part adds records after one, and from which record on."""
        place = self.parts.index(part) + 1
        later = [*zip(self.parts[place:], self.spans[place:], strict=True)]
        held = (pair for pair in later if pair[1].first <= pair[1].last)
        other, span = next(held, later[-1])
        return part_number(other), span.first

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the file; of several parts, that of their hexadecimal hashes in order."""
        digests = [part.sha256 for part in self.parts]
        text = "\n".join(digests)
        return text if len(digests) == 1 else hashlib.sha256(text.encode()).hexdigest()

    @cached_property
    def left_out_records(self) -> int:
        """How many records are in the files but, for a resume, not part of the session."""
        if not self.left_out:
            return 0
        return sum(
            within(raw.sequence, span) and not self._kept(raw.sequence, span)
            for part, span in zip(self.parts, self.spans, strict=True)
            for raw in part.raw()
        )

    @cached_property
    def left_out_trials(self) -> int:
        """How many fleet runs are among them: broken off."""
        if not self.left_out:
            return 0
        return sum(
            within(sequence, span) and not self._kept(sequence, span)
            for part, span in zip(self.parts, self.spans, strict=True)
            for sequence, _ in part.records(TrialStarted.topic)
        )

    def records(self, *topics: str) -> Iterator[tuple[int, Record]]:
        """Yield (sequence, record) in order of sequence; see `Recording.records`."""
        for part, span in zip(self.parts, self.spans, strict=True):
            for sequence, record in part.records(*topics):
                if self._kept(sequence, span):
                    yield sequence, record

    def every_record(self, *topics: str) -> Iterator[tuple[Record, bool]]:
        """Yield records of these topics, and whether they belong to the session.

        What a resume went back behind does not; a note of the experimenter is worth reading all
        the same.
        """
        for part, span in zip(self.parts, self.spans, strict=True):
            for sequence, record in part.records(*topics):
                if within(sequence, span):
                    yield record, self._kept(sequence, span)

    def raw(self, *families: Family, after: RawRecord | None = None) -> Iterator[RawRecord]:
        """Yield records undecoded, in order of sequence; see `Recording.raw`."""
        for part, span in zip(self.parts, self.spans, strict=True):
            if after is not None and span.last <= after.sequence:
                continue
            inside = after if after is not None and within(after.sequence, span) else None
            for raw in part.raw(*families, after=inside) if inside else part.raw(*families):
                if self._kept(raw.sequence, span):
                    yield raw

    def find(self, topic: str, sequence: int, log_time_ns: int) -> RawRecord | None:
        """Return one record; see `Recording.find`."""
        for part, span in zip(self.parts, self.spans, strict=True):
            if self._kept(sequence, span):
                return part.find(topic, sequence, log_time_ns)
        return None

    def columns(self, topic: str) -> list[dict[str, npt.NDArray[Any]]]:
        """Return a topic's records as arrays; see `Recording.columns`."""
        if len(self.parts) == 1:
            return self.parts[0].columns(topic)
        found: list[dict[str, npt.NDArray[Any]]] = []
        for part, span in zip(self.parts, self.spans, strict=True):
            for run in part.columns(topic):
                numbers = run["sequence"].astype(np.int64)
                kept = (numbers >= span.first) & (numbers <= span.last)
                for out in self.left_out:
                    kept &= (numbers < out.first) | (numbers > out.last)
                if kept.any():
                    found.append({name: values[kept] for name, values in run.items()})
        return found

    def _kept(self, sequence: int, span: Span) -> bool:
        return within(sequence, span) and not any(within(sequence, out) for out in self.left_out)


def read_session(path: Path) -> SessionRecording:
    """Open the session that a file belongs to, with the parts that lie beside it.

    Raises:
        RecordingError: there is no such file, it is no recording of ours, or was made by a newer
            version of this program.
    """
    given = read_recording(path)
    beside = [read_recording(other) for other in part_files(path) if other != path]
    parts = [given, *(part for part in beside if part.session_id == given.session_id)]
    return next(session for session in join_parts(parts) if given in session.parts)


def read_whole_session(path: Path) -> SessionRecording:
    """As `read_session`, for those who need a session from its beginning.

    Raises:
        RecordingError: as there; or the first part is not beside the one given.
    """
    recording = read_session(path)
    if recording.without_first:
        raise RecordingError(recording.without_first, "Put all parts into one folder.")
    return recording


def read_sessions(paths: Iterable[Path]) -> list[SessionRecording]:
    """Open recordings and join those of one session.

    Raises:
        RecordingError: one of them cannot be read.
    """
    return join_parts(read_recording(path) for path in paths)


def recordings_in(folder: Path) -> list[Path]:
    """Return the recordings that lie in a folder, by name; those not closed are among them."""
    return sorted([*folder.glob("*.mcap"), *folder.glob("*.mcap.part")])


def part_files(path: Path) -> list[Path]:
    """Return the parts of a recording that lie in its folder, in order, itself among them.

    They are told by their names: ``NAME.mcap``, ``NAME_part2.mcap``, ...; each may still end in
    ``.part``. A file that has just got its final name is listed by that alone. A salvaged copy,
    ``NAME_part2_salvaged.mcap``, is listed where it is given or its original is not there.
    """
    name = _FILE_NAME.fullmatch(path.name)
    if name is None:
        return [path]
    found = {int(name["part"] or 1): path} if name["copy"] else {}
    for other in sorted(path.parent.glob("*.mcap*")):
        match = _FILE_NAME.fullmatch(other.name)
        if match and match["name"] == name["name"]:
            found.setdefault(int(match["part"] or 1), other)
    return [found[number] for number in sorted(found)]


def part_name(name: str, part: int) -> str:
    """Return the name, without ``.mcap``, of a part of the recording called ``name``."""
    return name if part == 1 else f"{name}_part{part}"


def base_name(path: Path) -> str:
    """Return the name of a recording without part and suffixes: that of all its parts."""
    match = _FILE_NAME.fullmatch(path.name)
    return match["name"] if match else path.stem


def part_number(recording: Recording) -> int:
    """Return which part of its session a file is, from 1."""
    given = recording.metadata.get(PART, "1")
    return int(given) if given.isdecimal() else 1


def join_parts(recordings: Iterable[Recording]) -> list[SessionRecording]:
    """Join the parts of each session.

    A second file of the same part of a session is a copy: it makes a session of its own, so that
    nothing is taken twice. They come in the order of their first files.
    """
    groups: dict[tuple[str, int], dict[int, Recording]] = {}
    for place, recording in enumerate(recordings):
        number, identity = part_number(recording), recording.session_id
        copy = 0
        while number in groups.get((identity, copy), {}):
            copy += 1
        # A file too torn to say whose it is belongs to no other.
        key = (identity, copy) if identity else ("", -1 - place)
        groups.setdefault(key, {})[number] = recording
    return [_joined(tuple(group[n] for n in sorted(group))) for group in groups.values()]


def _joined(parts: tuple[Recording, ...]) -> SessionRecording:
    if len(parts) == 1 and part_number(parts[0]) == 1:
        return SessionRecording(parts, (ALL,), (), parts[0].losses)
    spans: list[Span] = []
    left_out: list[Span] = []
    faults: list[str] = []
    kept: list[npt.NDArray[np.int64]] = []
    seen = -1
    for place, part in enumerate(parts):
        numbers = np.fromiter((raw.sequence for raw in part.raw()), np.int64)
        if place:
            # The opening note of every part has the number 0.
            numbers = numbers[numbers > 0]
            repeated = numbers[numbers <= seen]
            if repeated.size:
                faults += disagreements(parts[:place], part, repeated)
        for sequence, record in part.records(SessionResumed.topic):
            if isinstance(record, SessionResumed) and sequence > seen:
                left_out.append(Span(record.after_sequence + 1, sequence - 1))
        last = int(numbers[-1]) if numbers.size else seen
        spans.append(Span(seen + 1, last))
        kept.append(numbers[numbers > seen])
        seen = max(seen, last)
    losses = gaps(np.concatenate(kept), left_out)
    faults += [
        f"Records {loss.first} to {loss.last} are in none of the parts found." for loss in losses
    ]
    # Of a torn end only the last part's is a loss: what other parts lack shows as a gap.
    losses += [loss for loss in parts[-1].losses if loss.last is None]
    return SessionRecording(parts, tuple(spans), tuple(left_out), tuple(losses), tuple(faults))
