"""What the analysis needs of one recording, wherever its records come from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy.typing as npt

from study.events.fields import Record
from study.recording.losses import Loss


class RecordingSource(Protocol):
    """What the analysis needs of one recording; `study.recording.reader` provides it."""

    @property
    def complete(self) -> bool:
        """Whether the file was finished properly."""

    @property
    def problems(self) -> Sequence[str]:
        """What is wrong with the file, in words."""

    @property
    def losses(self) -> Sequence[Loss]:
        """Which records are missing."""

    @property
    def sha256(self) -> str:
        """SHA-256 of the file, hexadecimal."""

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """Files kept inside the recording, by name."""

    def records(self, *topics: str) -> Iterator[tuple[int, Record]]:
        """Yield (sequence, record) of these topics, in the order written."""

    def every_record(self, *topics: str) -> Iterator[tuple[Record, bool]]:
        """Yield records, and whether they belong to the session: a resume leaves some out."""

    def columns(self, topic: str) -> list[dict[str, npt.NDArray[Any]]]:
        """Return a topic's fields as arrays, in blocks with a constant number of robots."""
