"""What a session keeps of its timesteps for later fits: little, for an hour has thirty thousand."""

from __future__ import annotations

from study.events.codes import Phase
from study.events.events import Timestep
from study.training_sets import DemonstrationBuffer, is_usable_choice


class KeptTimesteps:
    """Demonstrations and usable choices of one phase and condition, in order.

    Attributes:
        demonstrations: what policies are fitted to.
        choices: rows that scorers may be fitted to.
    """

    def __init__(self) -> None:
        self.demonstrations = DemonstrationBuffer()
        self.choices: list[Timestep] = []

    def add(self, row: Timestep, phase: Phase) -> None:
        """Take in one timestep; scorers are fitted to phase two's choices alone."""
        self.demonstrations.add(row)
        if phase == Phase.TWO and is_usable_choice(row):
            self.choices.append(row)

    def copy(self) -> KeptTimesteps:
        """Return one that goes on by itself; rows, which never change, are shared."""
        copied = KeptTimesteps()
        copied.demonstrations = self.demonstrations.copy()
        copied.choices = self.choices.copy()
        return copied
