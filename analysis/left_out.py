"""Which recordings are not analysed: of whom withdrew, was excluded or a pilot; unreadable ones."""

from __future__ import annotations

import dataclasses

from analysis.of_register import OfRegister
from study.events.inputs import SessionOpened
from study.recording.enrolled import not_analysed
from study.recording.identity import PILOT
from study.recording.parts import SessionRecording
from study.recording.register_folders import register_folder


@dataclasses.dataclass(frozen=True, slots=True)
class SetAside:
    """A recording that was given but is not analysed.

    Attributes:
        file: its name.
        participant: whose it is; empty if that cannot be read.
        reason: why it is not analysed.
        started_utc: when its session began, ISO 8601; empty if that cannot be read.
        unreadable: whether the file cannot be used; else it is left out on purpose.
    """

    file: str
    participant: str
    reason: str
    started_utc: str = ""
    unreadable: bool = False

    def __str__(self) -> str:
        """One line for the terminal."""
        what = "Cannot be used" if self.unreadable else "Left out"
        return f"{what}: {self.file}: {self.reason}"


class LeftOut:
    """Asks register and tombstones, beside recordings or above them; each folder is read once."""

    def __init__(self) -> None:
        self._reasons = OfRegister(not_analysed, "")

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
        found = self._reasons.of(folder, study, participant, operator_kind)
        # Where there is a register, it says who is a pilot: marks can be changed.
        unregistered = register_folder(folder) is None
        if not found and unregistered and recording.metadata.get(PILOT) == "true":
            return "a pilot session"
        return found


def beside(other: SessionOpened, chosen: SessionOpened, file: str) -> str:
    """Say why one session of a participant is not analysed beside the one that is, in a file."""
    if other.session_id == chosen.session_id:
        return f"a copy of the session that is analysed, {file}"
    return f"another session of {other.participant}; {file} is analysed"
