"""Control: the robot with the least health comes first. Nothing is learned."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.policies.base import Arrays, FitResult
from study.scorers._controls import settings_only

IS_CONTROL = True


class Parameters(BaseModel):
    """It has none."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class LowestHealth:
    """Scores a state by the health that is missing.

    Args:
        column: of health in the state.
    """

    def __init__(self, column: int) -> None:
        self._column = column

    def scores(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
        """Return minus the health of each of n states, float64 [n]."""
        health: npt.NDArray[np.float64] = states[..., self._column].astype(np.float64)
        return -health


def fit(
    arrays: Arrays,  # noqa: ARG001 - nothing is learned
    description: TaskDescription,
    parameters: Mapping[str, object] | Parameters,
    seed: int,  # noqa: ARG001
) -> FitResult:
    """Return what `load` needs; no data are used.

    Raises:
        StudyError: the task's state holds no health.
    """
    Parameters.model_validate(parameters)
    if description.health_field < 0:
        raise StudyError(
            f'the robots of task "{description.name}" have no health to be scored by',
            "Use another scorer.",
        )
    return settings_only()


def load(weights: bytes, description: TaskDescription) -> LowestHealth:  # noqa: ARG001
    """Return the scorer."""
    return LowestHealth(description.health_field)
