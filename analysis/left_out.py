"""Whose recordings are not analysed: withdrawn, excluded by the experimenter, pilots."""

from __future__ import annotations

from pathlib import Path

from study.recording.enrolled import FILE_NAME, not_analysed
from study.recording.identity import PILOT
from study.recording.parts import SessionRecording


class LeftOut:
    """Asks the register and the tombstones beside recordings; each folder is read once."""

    def __init__(self) -> None:
        self._reasons: dict[Path, dict[tuple[str, str], str]] = {}

    def reason(
        self, recording: SessionRecording, study: str, participant: str, operator_kind: str
    ) -> str:
        """Say why a session is left out; empty if it is not.

        Simulated participants have no place in a register.

        Raises:
            StudyError: register or tombstones are there but cannot be read.
        """
        if operator_kind != "person":
            return ""
        folder = recording.path.parent
        if folder not in self._reasons:
            self._reasons[folder] = not_analysed(folder)
        found = self._reasons[folder].get((study, participant), "")
        # Where there is a register, it says who is a pilot: marks can be changed.
        unregistered = not (folder / FILE_NAME).exists()
        if not found and unregistered and recording.metadata.get(PILOT) == "true":
            return "a pilot session"
        return found
