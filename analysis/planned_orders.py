"""The order of conditions that the plan had for a participant, by the register."""

from __future__ import annotations

from pathlib import Path

from study.recording.enrolled import planned_orders


class PlannedOrders:
    """Asks the register beside recordings or above them; each folder's is read once."""

    def __init__(self) -> None:
        self._known: dict[Path, dict[tuple[str, str], tuple[str, ...]]] = {}

    def order(
        self, folder: Path, study: str, participant: str, operator_kind: str
    ) -> tuple[str, ...]:
        """Return the order planned; empty if no register tells.

        Simulated participants have no place in a register.

        Raises:
            StudyError: the register is there but cannot be read.
        """
        if operator_kind != "person":
            return ()
        if folder not in self._known:
            self._known[folder] = planned_orders(folder)
        return self._known[folder].get((study, participant), ())
