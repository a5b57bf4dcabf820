"""Which records each part of a session contributes, and which are in none of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.recording.losses import Loss
from study.recording.reader import Recording


@dataclasses.dataclass(frozen=True, slots=True)
class Span:
    """Which sequence numbers one part contributes, both ends included; empty if last < first."""

    first: int
    last: int


ALL = Span(0, 2**64 - 1)


def within(sequence: int, span: Span) -> bool:
    """Return whether a span has a sequence number."""
    return span.first <= sequence <= span.last


def gaps(held: npt.NDArray[np.int64], left_out: list[Span]) -> list[Loss]:
    """Return which records of the session are in no part; those left out are not missed."""
    missing: list[Loss] = []
    # The opening note, number 0, says nothing of the session.
    held = held[held > 0]
    for place in np.flatnonzero(np.diff(held, prepend=0) > 1).tolist():
        first = int(held[place - 1]) + 1 if place else 1
        last = int(held[place]) - 1
        for out in sorted(left_out, key=lambda span: span.first):
            if within(first, out):
                first = out.last + 1
            if within(last, out):
                last = out.first - 1
        if first <= last:
            missing.append(Loss(first, last, None, None))
    return missing


def disagreements(
    before: tuple[Recording, ...], part: Recording, repeated: npt.NDArray[np.int64]
) -> list[str]:
    """Compare what a part repeats with what the parts before it hold."""
    numbers = Span(int(repeated[0]), int(repeated[-1]))
    theirs: dict[int, tuple[str, int, bytes]] = {}
    for earlier in before:
        for raw in earlier.raw():
            if raw.sequence and within(raw.sequence, numbers):
                theirs.setdefault(raw.sequence, (raw.topic, raw.log_time_ns, raw.data))
    for raw in part.raw():
        ours = (raw.topic, raw.log_time_ns, raw.data)
        if within(raw.sequence, numbers) and theirs.get(raw.sequence, ours) != ours:
            return [f"Record {raw.sequence} of {part.path.name} differs in a part before it."]
    return []
