"""A recorder whose records others see too, once the recorder has taken them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from study.events.fields import Record
from study.recording.failover import FailoverRecorder


class Tap(Protocol):
    """What sees a session's records. It must neither raise nor wait."""

    def offer(self, record: Record, log_time_ns: int, sequence: int) -> None:
        """See one record, with its log time and its number."""
        ...


class TappedRecorder:
    """Hands records to a recorder, then shows them to taps.

    Args:
        recorder: what records.
        taps: who sees every record after it was taken.
    """

    def __init__(self, recorder: FailoverRecorder, *taps: Tap) -> None:
        self._recorder = recorder
        self._taps = taps

    def write(self, record: Record, log_time_ns: int) -> int:
        """Record, then pass on; see `study.recording.failover.FailoverRecorder.write`."""
        sequence = self._recorder.write(record, log_time_ns)
        for tap in self._taps:
            tap.offer(record, log_time_ns, sequence)
        return sequence

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Record all or none, then pass them on."""
        last = self._recorder.write_together(records)
        for sequence, (record, log_time_ns) in enumerate(records, last - len(records) + 1):
            for tap in self._taps:
                tap.offer(record, log_time_ns, sequence)
        return last

    def ensure_durable(self, timeout_s: float) -> bool:
        """Wait until everything written is on disk; taps are not waited for."""
        return self._recorder.ensure_durable(timeout_s)
