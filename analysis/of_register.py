"""What the registers of recordings say of participants."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Generic, TypeVar

Said = TypeVar("Said")


class OfRegister(Generic[Said]):
    """Asks the register beside recordings or above them; each folder's is read once.

    Args:
        ask: reads a folder's, by study and pseudonym; raises a StudyError if it cannot.
        nothing: what is said where no register tells.
    """

    def __init__(
        self, ask: Callable[[Path], Mapping[tuple[str, str], Said]], nothing: Said
    ) -> None:
        self._ask = ask
        self._nothing = nothing
        self._known: dict[Path, Mapping[tuple[str, str], Said]] = {}

    def of(self, folder: Path, study: str, participant: str, operator_kind: str) -> Said:
        """Return what the register says of a participant.

        Simulated participants have no place in a register.

        Raises:
            StudyError: the register is there but cannot be read.
        """
        if operator_kind != "person":
            return self._nothing
        if folder not in self._known:
            self._known[folder] = self._ask(folder)
        return self._known[folder].get((study, participant), self._nothing)
