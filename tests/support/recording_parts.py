"""Reads the parts of a session independently of `study.recording.parts`, as an oracle."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from study.recording.losses import Loss
from study.recording.reader import RawRecord, read_recording


class Merged:
    """The records of several files by sequence number; of duplicates, which must be equal, one.

    Args:
        paths: the files, in order; opening notes are left out.
    """

    def __init__(self, paths: list[Path]) -> None:
        self.complete = True
        self.losses: tuple[Loss, ...] = ()
        self.rows: dict[int, RawRecord] = {}
        for path in paths:
            for raw in read_recording(path).raw():
                if raw.sequence:
                    assert self.rows.setdefault(raw.sequence, raw) == raw, raw.sequence

    def raw(self, *families: str) -> Iterator[RawRecord]:
        """Yield records in order of sequence."""
        for _, row in sorted(self.rows.items()):
            if not families or row.topic.split("/")[0] in families:
                yield row


def parts_in(folder: Path) -> list[Path]:
    """Return a folder's recordings in order of part.

    A part that was made this moment has no metadata yet, and no records: it is left out.
    """
    numbered = []
    for path in (*folder.glob("*.mcap"), *folder.glob("*.mcap.part")):
        recording = read_recording(path)
        if "part" in recording.metadata:
            numbered.append((int(recording.metadata["part"]), path))
        else:
            assert not recording.counts, path
    return [path for _, path in sorted(numbered)]
