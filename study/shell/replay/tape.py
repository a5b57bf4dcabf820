"""A recording that can be played from anywhere: the session's inputs, with forks of it on the way.

Nothing is stepped or scored: the session is fed with what was recorded. While the recording is
first read through, and compared with what follows, forks of the session are kept. To go to a
moment, the last fork before it is forked again and fed up to there.
"""

from __future__ import annotations

import bisect
import time
from collections.abc import Iterator

from study.events.inputs import Input
from study.recording.parts import SessionRecording
from study.recording.reader import RawRecord
from study.recording.wire import decode
from study.shell.replay.follower import Follower
from study.shell.replay.head import Head

SPACING_S = 0.006
"""Work between two forks, in seconds of this processor: done again to get from one to the next."""
MOST_FORKS = 800
"""When there are so many every second one is let go, and later ones are twice as far apart."""


class Tape:
    """Goes to any moment of a session.

    Args:
        recording: with its first part.

    Attributes:
        read_ns: session time up to which the recording was read through.
        difference: why the replay ends before the recording does, in words; empty if it does not.

    Raises:
        RecordingError: the recording opens no session.
    """

    def __init__(self, recording: SessionRecording) -> None:
        self._recording = recording
        # Sequence number of the first record that is not replayed.
        self._before = recording.losses[0].first if recording.losses else None
        self._head = Head()
        self._next: tuple[RawRecord, Input] | None = None
        self._inputs = self._inputs_after(None)
        self._forks = [Head()]
        self._spacing_s = SPACING_S
        self._worked_s = 0.0
        self._follower = Follower()
        self._scout = Head(session=self._follower.session)
        self._ahead: Iterator[RawRecord] | None = self._raw()
        self.read_ns = -1
        self.difference = ""
        # The first input opens the session: what is wrong with it is said at once.
        self.read(0.0)

    @property
    def is_read(self) -> bool:
        """Whether the recording was read through."""
        return self._ahead is None

    @property
    def forks(self) -> int:
        """How many forks of the session are kept."""
        return len(self._forks)

    def read(self, seconds: float) -> None:
        """Read on for a time, or to the end; at least one input.

        Raises:
            RecordingError: the recording cannot be read.
        """
        began = time.perf_counter()
        while self._ahead is not None:
            raw = next(self._ahead, None)
            if raw is None:
                self._follower.end(complete=self._recording.complete)
            if raw is None or not self._follow(raw):
                self._end_reading()
                return
            if raw.topic.startswith("input/") and time.perf_counter() - began >= seconds:
                return

    def go_to(self, t_ns: int) -> Head:
        """Return the session as it was at a time, after all that happened then.

        The recording is read on to that time if it was not yet.

        Args:
            t_ns: session time.
        """
        while not self.is_read and self.read_ns <= t_ns:
            self.read(0.05)
        place = bisect.bisect_right(self._forks, t_ns, key=lambda head: head.t_ns) - 1
        start = self._forks[max(0, place)]
        if t_ns < self._head.t_ns or start.t_ns > self._head.t_ns:
            self._head = start.fork()
            self._inputs = self._inputs_after(start.last)
            self._next = next(self._inputs, None)
        elif self._next is None:
            self._next = next(self._inputs, None)
        while self._next is not None and self._next[1].t_ns <= t_ns:
            self._head.feed(*self._next)
            self._next = next(self._inputs, None)
        return self._head

    def _raw(self) -> Iterator[RawRecord]:
        """Yield inputs and events, up to the first that is lost."""
        for raw in self._recording.raw("input", "event"):
            if self._before is not None and raw.sequence >= self._before:
                self.difference = f"record {self._before} is missing: the replay ends there"
                return
            yield raw

    def _follow(self, raw: RawRecord) -> bool:
        """Take one record; return whether what follows can be replayed."""
        began = time.thread_time()
        fed = self._follower.take(raw)
        if self._follower.difference:
            return False
        if fed is not None:
            self._scout.take_note(raw, fed.given, fed.step)
            self.read_ns = self._scout.t_ns
            self._worked_s += time.thread_time() - began
            if self._worked_s >= self._spacing_s:
                self._keep()
        return True

    def _keep(self) -> None:
        """Keep a fork of the session as it is."""
        self._worked_s = 0.0
        self._forks.append(self._scout.fork())
        if len(self._forks) >= MOST_FORKS:
            self._forks = self._forks[::2]
            self._spacing_s *= 2

    def _end_reading(self) -> None:
        self._ahead = None
        last = self._scout.last
        if self._follower.difference and last is not None:
            # What the last input led to is not what was recorded.
            self._before = last.sequence
            self._forks = [
                head for head in self._forks if head.last is None or head.last is not last
            ]
            self.difference = f"{self._follower.difference}: the replay ends there"

    def _inputs_after(self, last: RawRecord | None) -> Iterator[tuple[RawRecord, Input]]:
        """Yield the inputs that can be replayed, decoded, after one of them."""
        for raw in self._recording.raw("input", after=last):
            if self._before is not None and raw.sequence >= self._before:
                return
            given: Input = decode(raw.topic, raw.data)  # type: ignore[assignment]
            yield raw, given
