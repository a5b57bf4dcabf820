"""The action of the nearest demonstration: 1-nearest-neighbour under L2.

Equally near demonstrations: the most recent one decides, so that a correction always
overrules what it corrects.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import safetensors.numpy
from pydantic import BaseModel, ConfigDict, Field
from scipy.spatial import cKDTree

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.features import Encoding, encode
from study.policies.base import Arrays, FitResult

ENCODINGS: tuple[Encoding, ...] = ("sine_cosine", "scaled", "raw")


class Parameters(BaseModel):
    """What a protocol can set of the policy."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    encoding: Encoding = Field(
        "sine_cosine",
        description='what distances are measured in: "sine_cosine" (angles as points of '
        'a circle of circumference 1, the rest divided by its range), "scaled" (all divided '
        'by their range) or "raw"',
    )


def fit(
    arrays: Arrays,
    description: TaskDescription,
    parameters: Mapping[str, object] | Parameters,
    seed: int,
) -> FitResult:
    """Keep the demonstrations, of equal states the most recent.

    Args:
        arrays: ``states`` float32 [m, d] and ``actions`` int32 [m], oldest first.
        description: the task's.
        parameters: as in a protocol.
        seed: unused: nothing is drawn.

    Raises:
        StudyError: there is no demonstration, or a state is not finite.
    """
    del seed
    settings = Parameters.model_validate(parameters)
    states, actions = arrays["states"].astype(np.float32), arrays["actions"].astype(np.int32)
    if not len(states):
        raise StudyError(
            "there are no demonstrations to fit the policy to",
            "Drive the robot for a few timesteps before the policy is fitted.",
        )
    if not np.isfinite(states).all():
        raise StudyError("a demonstration's state holds a number that is not finite")
    features = encode(states, description.state_fields, settings.encoding)
    # Rows are told apart by their features, which distances are measured in; of equal
    # rows np.unique keeps the first, which after reversal is the most recent.
    _, last = np.unique(features[::-1], axis=0, return_index=True)
    kept = np.sort(len(features) - 1 - last)
    weights = safetensors.numpy.save(
        {
            "states": states[kept],
            "actions": actions[kept],
            "encoding": np.array([ENCODINGS.index(settings.encoding)], np.int32),
        }
    )
    return FitResult(
        weights=weights,
        metrics={"demonstrations": float(len(states)), "kept": float(len(kept))},
    )


def load(weights: bytes, description: TaskDescription) -> NearestNeighbor:
    """Return the policy that `fit` made."""
    tensors = safetensors.numpy.load(weights)
    return NearestNeighbor(
        tensors["states"], tensors["actions"], description, ENCODINGS[int(tensors["encoding"][0])]
    )


class NearestNeighbor:
    """1-nearest-neighbour under L2 over features.

    Args:
        states: float32 [m, d], demonstrated states with distinct features, oldest first.
        actions: int32 [m].
        description: the task's.
        encoding: what distances are measured in.
    """

    def __init__(
        self,
        states: npt.NDArray[np.float32],
        actions: npt.NDArray[np.int32],
        description: TaskDescription,
        encoding: Encoding,
    ) -> None:
        self._fields = description.state_fields
        self._encoding = encoding
        self._actions = actions
        self._features = encode(states, self._fields, encoding)
        self._tree = cKDTree(self._features)
        self._ranks = [1, 2][: len(self._features)]

    def actions(
        self, states: npt.NDArray[np.float32], random: np.random.Generator
    ) -> npt.NDArray[np.int32]:
        """Return the nearest demonstration's action for each of n states.

        Args:
            states: float32 [n, d].
            random: left alone.

        Returns:
            int32 [n].
        """
        del random
        return self._actions[self.nearest(states)]

    def nearest(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.intp]:
        """Return the index of the nearest demonstration, of equally near ones the most recent.

        Args:
            states: float32 [n, d].

        Returns:
            intp [n].
        """
        queries = encode(states, self._fields, self._encoding)
        # The tree returns any one of equally near neighbours. Two are asked for; only where
        # they are (almost) equally near are all that could tie fetched and compared exactly.
        answer = self._tree.query(queries, k=self._ranks)
        distances, found = np.asarray(answer[0]), np.asarray(answer[1])
        nearest: npt.NDArray[np.intp] = found[:, 0].astype(np.intp)
        close = distances[:, -1] <= distances[:, 0] * (1 + 1e-9)
        for row in close.nonzero()[0]:
            reach = distances[row, 0] * (1 + 1e-9)
            tied = np.sort(self._tree.query_ball_point(queries[row], reach))
            squared = squared_distances(self._features[tied], queries[row])
            nearest[row] = tied[np.flatnonzero(squared == squared.min())[-1]]
        return nearest


def squared_distances(
    features: npt.NDArray[np.float64], query: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the squared L2 distances [m] of features [m, k] to one query [k]."""
    squared: npt.NDArray[np.float64] = ((features - query) ** 2).sum(axis=1)
    return squared
