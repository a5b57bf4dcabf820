"""What was taken and is not yet known to be on disk."""

from __future__ import annotations

from collections import deque

from study.recording.framing import MESSAGE_HEADER, frame_payload


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
        self._kept: deque[bytes] = deque()
        self._waiting_since_ns = 0
        self.sent = self.durable = first_sequence - 1
        self.durable_log_time_ns = 0
        self.size = 0

    def add(self, framed: bytes, now_ns: int) -> None:
        """Add the next record, at a time on any one clock."""
        if not self._kept:
            self._waiting_since_ns = now_ns
        self._kept.append(framed)
        self.sent += 1
        self.size += len(framed)

    def acknowledge(self, sequence: int, now_ns: int) -> None:
        """Forget the records up to a number: they are on disk."""
        last = b""
        while self._kept and self.durable < sequence:
            last = self._kept.popleft()
            self.size -= len(last)
            self.durable += 1
        if last:
            self._waiting_since_ns = now_ns
            self.durable_log_time_ns = MESSAGE_HEADER.unpack_from(frame_payload(last))[2]

    def waiting_since_ns(self) -> int | None:
        """Return since when records wait without any having become durable; None if none wait."""
        return self._waiting_since_ns if self._kept else None

    def frames(self) -> list[bytes]:
        """Return what waits, in order."""
        return list(self._kept)
