"""What a session took in, and the pictures that its participant saw."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from study.commands.recorded_scorers import recorded_weights
from study.commands.simulating import simulated_assignments
from study.commands.unrecorded import NoRecorder, run_unrecorded
from study.events.fields import Record
from study.events.inputs import FleetObserved, Input
from study.loading import load_protocol
from study.messages import messages_for
from study.shell.fitting import InlineFitter
from study.shell.virtual_loop import VirtualClock

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


def seen_session(protocol: Path) -> SeenInputs:
    """Simulate a session of a protocol; return what it took in and what was seen."""
    loaded = load_protocol(str(protocol))
    (assignment,) = simulated_assignments(loaded, 1, seed=3)
    kept = SeenInputs()
    run_unrecorded(
        loaded,
        assignment,
        messages_for("en"),
        VirtualClock(),
        fitter=InlineFitter(loaded.description, recorded_weights(loaded)),
        on_show=lambda _: None,
        on_pictures=kept.take,
        recorder=kept,
    )
    return kept
