"""Control: the robot that has stayed in its place longest comes first. Nothing is learned.

A strong baseline: it needs no choices of the operator's at all.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field

from study.events.task_description import TaskDescription
from study.policies.base import Arrays, FitResult
from study.scorers._controls import setting, settings_only

IS_CONTROL = True


class Parameters(BaseModel):
    """What a protocol can set of the scorer."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    distance: float = Field(
        1.0, gt=0, description="a robot that stays within it is stuck; metres in x or y"
    )


class StuckScorer:
    """Counts the timesteps since each robot left its place.

    Args:
        places: columns of x and y in the state; all columns where a task has no places.
        distance: how far a robot must go.
    """

    def __init__(self, places: list[int], distance: float) -> None:
        self._places = places
        self._distance = distance
        self._anchors: npt.NDArray[np.float64] | None = None
        self._counts = np.zeros(0)

    def begin(self, robots: int, seed: int) -> None:  # noqa: ARG002 - scorers are begun alike
        """Forget the fleet run before."""
        self._anchors = None

    def scores(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
        """Return how many timesteps each of n robots has stayed in its place, float64 [n].

        Called once a timestep with the whole fleet; another number of robots begins anew.
        """
        places = states[..., self._places].astype(np.float64) if self._places else states
        if self._anchors is None or self._anchors.shape != places.shape:
            self._anchors = np.array(places, dtype=np.float64)
            self._counts = np.zeros(places.shape[:-1])
            return self._counts.copy()
        moved = np.abs(places - self._anchors).max(axis=-1) > self._distance
        self._anchors[moved] = places[moved]
        self._counts = np.where(moved, 0.0, self._counts + 1.0)
        return self._counts.copy()


def fit(
    arrays: Arrays,  # noqa: ARG001 - nothing is learned
    description: TaskDescription,  # noqa: ARG001
    parameters: Mapping[str, object] | Parameters,
    seed: int,  # noqa: ARG001
) -> FitResult:
    """Return what `load` needs; no data are used."""
    settings = Parameters.model_validate(parameters)
    return settings_only(distance=settings.distance)


def load(weights: bytes, description: TaskDescription) -> StuckScorer:
    """Return the scorer."""
    places = [description.x_field, description.y_field]
    return StuckScorer(places if min(places) >= 0 else [], setting(weights, "distance"))
