"""Control: the robot in the strangest state comes first, far from all where the operator was.

Novelty is the distance to the nearest state in which the operator operated a robot, in the
encoding that the nearest-neighbour policy measures distances in. What the operator chose among
is not looked at, so it learns nothing of their preferences.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import safetensors.numpy
from pydantic import BaseModel, ConfigDict
from scipy.spatial import cKDTree

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.features import encode
from study.policies.base import Arrays, FitResult

IS_CONTROL = True


class Parameters(BaseModel):
    """It has none."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class NoveltyScorer:
    """Scores a state by its distance to the nearest known one.

    Args:
        known: float32 [m, d], m at least 1.
        description: the task's.
    """

    def __init__(self, known: npt.NDArray[np.float32], description: TaskDescription) -> None:
        self._fields = description.state_fields
        self._tree = cKDTree(encode(known, self._fields))

    def scores(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
        """Return how far each of n states is from the nearest known one, float64 [n]."""
        distances: npt.NDArray[np.float64] = np.asarray(
            self._tree.query(encode(states, self._fields))[0], np.float64
        )
        return distances


def fit(
    arrays: Arrays,
    description: TaskDescription,  # noqa: ARG001 - fits are called alike
    parameters: Mapping[str, object] | Parameters,
    seed: int,  # noqa: ARG001
) -> FitResult:
    """Keep the states of the robots operated.

    Args:
        arrays: ``states`` float32 [m, n, d] and ``chosen`` int32 [m].
        description: the task's.
        parameters: as in a protocol.
        seed: unused: nothing is drawn.

    Raises:
        StudyError: there are no choices, or a state is not finite.
    """
    Parameters.model_validate(parameters)
    states, chosen = arrays["states"].astype(np.float32), arrays["chosen"].astype(np.int64)
    if not len(chosen):
        raise StudyError(
            "there are no states that the operator has been in",
            "Operate robots for a few timesteps before the scorer is fitted.",
        )
    known = np.unique(states[np.arange(len(chosen)), chosen], axis=0)
    if not np.isfinite(known).all():
        raise StudyError("a state among the choices holds a number that is not finite")
    return FitResult(weights=safetensors.numpy.save({"states": known}), metrics={})


def load(weights: bytes, description: TaskDescription) -> NoveltyScorer:
    """Return the scorer."""
    return NoveltyScorer(safetensors.numpy.load(weights)["states"], description)
