"""Tells Foxglove exports, which lie among recordings and are none, by what they begin with."""

from __future__ import annotations

import dataclasses
import struct
from pathlib import Path

from study.recording.mcap_records import HEADER, MAGIC, METADATA, DamagedError, metadata_record
from study.recording.mcap_walk import record_at

EXPORT_PROFILE = "scaled_autonomy_foxglove"
"""Not the profile of a recording, nor are there its metadata: it is never taken for one."""
EXPORTED_FROM = "exported_from"
"""Key of the names of the recording's files, by commas."""
STUDY = "study"
PARTICIPANT = "participant"
"""Keys of whose data they are."""


@dataclasses.dataclass(frozen=True, slots=True)
class ExportOf:
    """What an export says of itself.

    Attributes:
        files: names of the recording's files.
        study: of whose protocol; empty in exports of earlier versions.
        participant: whose data they are; likewise.
    """

    files: tuple[str, ...]
    study: str
    participant: str

    def __str__(self) -> str:
        """What it is, in words."""
        return f"a Foxglove export of {', '.join(self.files)[:300]}"


def export_of(path: Path) -> ExportOf | None:
    """Return what a file was exported from; None if it is no export, or cannot be read."""
    try:
        size = path.stat().st_size
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                return None
            header = record_at(stream, len(MAGIC), size)
            if header.opcode != HEADER:
                return None
            record = record_at(stream, header.start + len(header.payload), size)
        if record.opcode != METADATA:
            return None
        name, entries = metadata_record(record.payload)
    except (OSError, DamagedError, struct.error, UnicodeDecodeError):
        return None
    if name != EXPORT_PROFILE:
        return None
    files = tuple(filter(None, entries.get(EXPORTED_FROM, "").split(", ")))
    return ExportOf(files, entries.get(STUDY, ""), entries.get(PARTICIPANT, ""))
