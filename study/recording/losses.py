"""What a recording lacks: in numbers for programs, in words for people."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence

from study.errors import RecordingError


@dataclasses.dataclass(frozen=True, slots=True)
class Loss:
    """Consecutive records that are missing.

    Attributes:
        first: sequence number of the first one missing.
        last: of the last; None if the end is missing and nobody knows how much there was.
        after_ns: log time of the record before; None if there is none.
        before_ns: log time of the record after; None if there is none.
    """

    first: int
    last: int | None
    after_ns: int | None
    before_ns: int | None

    @property
    def count(self) -> int | None:
        """Number of records missing, None if unknown."""
        return None if self.last is None else self.last - self.first + 1

    def overlaps(self, first: int, last: int | None) -> bool:
        """Whether a record from `first` to `last` (None: without end) is missing."""
        return (last is None or self.first <= last) and (self.last is None or first <= self.last)

    def text(self, origin_ns: int) -> str:
        """Return the loss in words, times in seconds after the recording was opened."""
        start = "" if self.after_ns is None else f"{(self.after_ns - origin_ns) / 1e9:.2f} s"
        end = "" if self.before_ns is None else f"{(self.before_ns - origin_ns) / 1e9:.2f} s"
        if start and end:
            when = f", between {start} and {end}"
        elif start or end:
            when = f", after {start}" if start else f", before {end}"
        else:
            when = ""
        if self.last is None:
            return f"The end is missing, from record {self.first} on{when}."
        if self.count == 1:
            return f"Record {self.first} is missing{when}."
        return f"Records {self.first} to {self.last} are missing ({self.count}){when}."


def to_json(losses: Sequence[Loss]) -> str:
    """Return losses as text for a salvaged file's metadata."""
    return json.dumps([dataclasses.astuple(loss) for loss in losses])


def from_json(text: str) -> tuple[Loss, ...]:
    """Return the losses that a salvaged file's metadata state.

    Raises:
        RecordingError: the text states none.
    """
    try:
        losses = tuple(Loss(*item) for item in json.loads(text))
        numbers = [number for loss in losses for number in dataclasses.astuple(loss)]
        if not all(number is None or type(number) is int for number in numbers):
            raise TypeError("a whole number is expected")
        if any(type(loss.first) is not int for loss in losses):
            raise TypeError("a whole number is expected")
    except (ValueError, TypeError, RecursionError) as error:
        raise RecordingError(
            f"the metadata of a salvaged file are unreadable: {error}",
            "Salvage the original again with `study recover`.",
        ) from error
    return losses


def counts_text(counts: Mapping[str, int]) -> str:
    """Return counts by topic in words: "30 event/timestep, 2 event/switched"."""
    return ", ".join(f"{count} {topic}" for topic, count in sorted(counts.items()))
