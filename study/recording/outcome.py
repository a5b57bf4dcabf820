"""What is safe of a recording that ended too early, in words."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime
from pathlib import Path


@dataclasses.dataclass(frozen=True, slots=True)
class Outcome:
    """How far a recording got.

    Attributes:
        sent: number of the last record taken.
        durable: number of the last record known to be on disk.
        durable_log_time_ns: that record's log time, ns since 1970, UTC; 0 if there is none.
        file_lost: whether the last part is gone, with all that it held.
        paths: its parts, those that exist among them.
    """

    sent: int
    durable: int
    durable_log_time_ns: int
    file_lost: bool
    paths: tuple[Path, ...]

    def what_is_safe(self) -> str:
        """Return a sentence without its full stop."""
        if self.file_lost:
            return "What it held is not safe"
        if self.durable == self.sent:
            return f"All {self.sent} records are safe, but the file could not be finished"
        if not self.durable_log_time_ns:
            return f"None of its {self.sent} records is safe"
        moment = datetime.fromtimestamp(self.durable_log_time_ns / 1e9, UTC)
        return (
            f"It is safe up to {moment.isoformat(' ', 'milliseconds')} (record {self.durable}); "
            f"{self.sent - self.durable} records after that are not"
        )

    def what_there_is(self, folder: Path) -> str:
        """Return a sentence that names the files."""
        names = ", ".join(path.name for path in self.paths if path.exists())
        return f"What there is, is in {folder}: {names or 'nothing'}."
