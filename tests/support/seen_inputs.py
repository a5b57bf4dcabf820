"""What a session took in, and the pictures that its participant saw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from study.commands.unrecorded import NoRecorder
from study.events.fields import Record
from study.events.inputs import FleetObserved, Input

Shots = npt.NDArray[np.uint8]


class SeenInputs(NoRecorder):
    """Keeps the inputs of a session, and the pictures that came before each answer."""

    def __init__(self) -> None:
        self.inputs: list[Input] = []
        self.pictures: dict[int, Shots] = {}
        self._newest: Shots | None = None

    def take(self, pictures: Shots) -> None:
        """Keep the newest pictures until the answer that they belong to."""
        self._newest = pictures

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Keep the input, and the pictures that came before it."""
        given: Input = records[0][0]  # type: ignore[assignment]
        self.inputs.append(given)
        if isinstance(given, FleetObserved) and self._newest is not None:
            self.pictures[given.request_id], self._newest = self._newest, None
        return 0
