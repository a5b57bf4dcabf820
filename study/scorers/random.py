"""Control: a fresh random score for each robot at each timestep, from the session's seed.

With it, the robot changes as in an assisted condition, and nothing of the operator is in it:
what remains of an effect is that of being switched.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict

from study.events.task_description import TaskDescription
from study.policies.base import Arrays, FitResult
from study.scorers._controls import settings_only

IS_CONTROL = True


class Parameters(BaseModel):
    """It has none: its numbers come from the session's seed and the trial's place."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class RandomScorer:
    """Draws anew at every call; `begin` keys the stream."""

    def __init__(self) -> None:
        self._random = np.random.default_rng(0)

    def begin(self, robots: int, seed: int) -> None:  # noqa: ARG002 - scorers are begun alike
        """Start the stream of a fleet run."""
        self._random = np.random.Generator(np.random.PCG64([seed, 0x5C0]))

    def scores(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
        """Return a number from 0 to 1 for each of n states, float64 [n]."""
        return self._random.random(states.shape[:-1])


def fit(
    arrays: Arrays,  # noqa: ARG001 - nothing is learned
    description: TaskDescription,  # noqa: ARG001
    parameters: Mapping[str, object] | Parameters,
    seed: int,  # noqa: ARG001
) -> FitResult:
    """Return what `load` needs; no data are used."""
    Parameters.model_validate(parameters)
    return settings_only()


def load(weights: bytes, description: TaskDescription) -> RandomScorer:  # noqa: ARG001
    """Return the scorer."""
    return RandomScorer()
