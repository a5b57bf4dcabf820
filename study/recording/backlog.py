"""What was taken and is not yet known to be on disk."""

from __future__ import annotations

import dataclasses
from collections import deque


@dataclasses.dataclass(frozen=True, slots=True)
class Framed:
    """Records that travel together, as one frame.

    Attributes:
        frame: the bytes.
        records: how many there are.
        log_time_ns: of the last one.
    """

    frame: bytes
    records: int
    log_time_ns: int


class Backlog:
    """Framed records in order of sequence, from the first one that may still be lost.

    Args:
        first_sequence: number of the first record that will be added.

    Attributes:
        sent: number of the last record added.
        durable: number of the last record known to be on disk.
        durable_log_time_ns: its log time; 0 before the first.
        size: bytes waiting.
    """

    def __init__(self, first_sequence: int) -> None:
        self._kept: deque[Framed] = deque()
        self._waiting_since_ns = 0
        self.sent = self.durable = first_sequence - 1
        self.durable_log_time_ns = 0
        self.size = 0

    def add(self, framed: Framed, now_ns: int) -> None:
        """Add the next records, at a time on any one clock."""
        if not self._kept:
            self._waiting_since_ns = now_ns
        self._kept.append(framed)
        self.sent += framed.records
        self.size += len(framed.frame)

    def acknowledge(self, sequence: int, now_ns: int) -> None:
        """Forget the records up to a number: they are on disk."""
        last = None
        while self._kept and self.durable + self._kept[0].records <= sequence:
            last = self._kept.popleft()
            self.size -= len(last.frame)
            self.durable += last.records
        if last is not None:
            self._waiting_since_ns = now_ns
            self.durable_log_time_ns = last.log_time_ns

    def waiting_since_ns(self) -> int | None:
        """Return since when records wait without any having become durable; None if none wait."""
        return self._waiting_since_ns if self._kept else None

    def oldest_log_time_ns(self) -> int | None:
        """Return the log time of the oldest record that waits; None if none does."""
        try:
            return self._kept[0].log_time_ns
        except IndexError:
            return None

    def frames(self) -> list[Framed]:
        """Return what waits, in order."""
        return list(self._kept)
