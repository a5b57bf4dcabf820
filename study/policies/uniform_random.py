"""Every action but idling with equal chance: what the robots start phase one with."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict

from study.events.task_description import TaskDescription


class Parameters(BaseModel):
    """There is nothing to set."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def create(description: TaskDescription) -> UniformRandom:
    """Return the policy; it is not fitted and has no weights."""
    actions = range(len(description.action_names))
    return UniformRandom([action for action in actions if action != description.idle_action])


class UniformRandom:
    """Draws among actions with equal chance.

    Args:
        choices: the action numbers to draw from.
    """

    def __init__(self, choices: list[int]) -> None:
        self._choices = np.array(choices, np.int32)

    def actions(
        self, states: npt.NDArray[np.float32], random: np.random.Generator
    ) -> npt.NDArray[np.int32]:
        """Draw an action for each of n states.

        Args:
            states: float32 [n, d]; only n matters.
            random: the policy's own stream.

        Returns:
            int32 [n].
        """
        return self._choices[random.integers(len(self._choices), size=len(states))]
