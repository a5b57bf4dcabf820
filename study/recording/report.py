"""What a writer process has said of itself."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

from study.recording.framing import FrameKind


@dataclasses.dataclass(slots=True)
class WriterReport:
    """The sum of the writer's answers, but for how far the disk has got.

    Attributes:
        ready: whether the file's beginning is on disk.
        finished: the complete file; None before it is.
        cause: what went wrong and what to do, in words; empty if nothing did.
        file_lost: whether the file is gone, with what was durable.
        remarks: what went wrong outside and was mended, in words, oldest first.
    """

    ready: bool = False
    finished: Path | None = None
    cause: tuple[str, str] = ("", "")
    file_lost: bool = False
    remarks: list[str] = dataclasses.field(default_factory=list)

    def take(self, kind: FrameKind, payload: bytes) -> None:
        """Take in one answer."""
        if kind is FrameKind.READY:
            self.ready = True
        elif kind is FrameKind.FINISHED:
            self.finished = Path(payload.decode())
        elif kind is FrameKind.REMARK:
            self.remarks.append(payload.decode())
        elif kind is FrameKind.FAILED:
            failed = json.loads(payload)
            self.cause = (failed["message"], failed["hint"])
            self.file_lost = failed["lost"]

    def take_remarks(self) -> list[str]:
        """Return, once, each remark."""
        return [self.remarks.pop(0) for _ in range(len(self.remarks))]
