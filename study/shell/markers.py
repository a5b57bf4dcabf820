"""Markers: what of a session is told to other instruments while it runs, as text.

A marker is an event of the recording without its arrays, as a JSON object on one line:
``topic``, ``sequence`` (the record's number in the recording), then the event's fields under
their own names. So the recording's reference explains every marker, and each can be found in the
recording by its number.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Final, Protocol

import numpy as np

from study.events.events import (
    Deviation,
    Event,
    Paused,
    QuestionAnswered,
    Resumed,
    RewardRevealed,
    SessionEnded,
    SessionStarted,
    StageEntered,
    Switched,
    TrialEnded,
    TrialStarted,
)
from study.events.fields import wire_fields
from study.events.shell import LslClockPair, Note, ShellObservation

MARKED: Final[tuple[type[Event], ...]] = (
    SessionStarted,
    StageEntered,
    TrialStarted,
    Switched,
    TrialEnded,
    QuestionAnswered,
    RewardRevealed,
    Paused,
    Resumed,
    Deviation,
    SessionEnded,
)
"""The events that become markers: what frames trials, takeovers and surveys."""

PAIR_EVERY_NS: Final = 10_000_000_000
"""How old a pair of clock readings may be when a marker is stamped by it."""
_READINGS = 5
_SECOND = 1_000_000_000


class Outlet(Protocol):
    """Where markers go: `study.shell.lsl`, or a stand-in."""

    def clock(self) -> float:
        """Return the outlet's clock, s; it runs as fast as the session's."""
        ...

    def push(self, marker: str, at_seconds: float) -> None:
        """Publish a marker that belongs to an instant of the outlet's clock; do not wait."""
        ...

    def close(self) -> None:
        """End the stream, after a moment in which those who receive get the last markers."""
        ...


def marker(sequence: int, event: Event) -> str:
    """Return an event as a marker: its topic, number and fields, arrays left out."""
    values: dict[str, object] = {"topic": event.topic, "sequence": sequence}
    for name in wire_fields(type(event)):
        value = getattr(event, name)
        if not isinstance(value, np.ndarray):
            # JSON has no NaN; Python's encoder would write one all the same.
            odd = isinstance(value, float) and not np.isfinite(value)
            values[name] = None if odd else value
    return json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


class MarkerPublisher:
    """Publishes a session's markers; whatever goes wrong is noted, and costs the session nothing.

    Args:
        outlet: where they go.
        now: the session's time, ns.
        observe: records an observation of the shell.

    Attributes:
        failure: why no more markers are published, in words; empty while all is well.
    """

    def __init__(
        self,
        outlet: Outlet,
        now: Callable[[], int],
        observe: Callable[[ShellObservation], None],
    ) -> None:
        self._outlet = outlet
        self._now = now
        self._observe = observe
        self._pair: LslClockPair | None = None
        self.failure = ""

    def publish(self, events: Sequence[tuple[int, Event]]) -> None:
        """Publish those events that are marked, each at its own time.

        The time of an event is mapped by the newest pair of clock readings, which is recorded:
        ``lsl_seconds + (event's t_ns - pair's t_ns) / 1e9``.

        Args:
            events: with their numbers in the recording.
        """
        marked = [(number, event) for number, event in events if isinstance(event, MARKED)]
        if not marked or self.failure:
            return
        try:
            pair = self._fresh_pair()
            for number, event in marked:
                at_seconds = pair.lsl_seconds + (event.t_ns - pair.t_ns) / _SECOND
                self._outlet.push(marker(number, event), at_seconds)
        except Exception as error:
            self._fail(error)

    def _fresh_pair(self) -> LslClockPair:
        if self._pair is None or self._now() - self._pair.t_ns > PAIR_EVERY_NS:
            self._pair = self._read_pair()
            self._observe(self._pair)
        return self._pair

    def _read_pair(self) -> LslClockPair:
        """Read both clocks some times; take the pair whose readings are closest together."""
        best: LslClockPair | None = None
        for _ in range(_READINGS):
            before = self._now()
            seconds = self._outlet.clock()
            after = self._now()
            if best is None or after - before < best.uncertainty_ns:
                best = LslClockPair((before + after) // 2, seconds, after - before)
        assert best is not None  # noqa: S101 - there is at least one reading
        return best

    def _fail(self, error: Exception) -> None:
        self.failure = f"{type(error).__name__}: {error}"
        self._observe(Note(self._now(), f"no more markers are published: {self.failure}"))
