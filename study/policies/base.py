"""The policy contract: states to actions.

A member's module has ``Parameters`` (a pydantic model), ``fit`` and ``load``; see
`FitModule`. Loading and acting import no torch.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from study.events.task_description import TaskDescription

Arrays = Mapping[str, npt.NDArray[Any]]


@dataclasses.dataclass(frozen=True, slots=True)
class FitResult:
    """What a fit returned.

    Attributes:
        weights: safetensors bytes with all that ``load`` needs, input scaling included.
        metrics: measures of fit by name.
        preparation: safetensors bytes that a later fit to more data can go on from; empty if
            there is nothing to go on from.
    """

    weights: bytes
    metrics: dict[str, float]
    preparation: bytes = b""


class Policy(Protocol):
    """Maps states to actions."""

    def actions(
        self, states: npt.NDArray[np.float32], random: np.random.Generator
    ) -> npt.NDArray[np.int32]:
        """Return an action for each of n states.

        Args:
            states: float32 [n, d].
            random: the policy's own stream; a deterministic policy leaves it alone.

        Returns:
            int32 [n].
        """
        ...


class FitModule(Protocol):
    """What a policy's or scorer's module offers.

    ``fit`` raises `study.errors.StudyError` with the reason in words when the data cannot
    be fitted (no rows, one class, numbers that are not finite).
    """

    Parameters: type[Any]

    def fit(
        self,
        arrays: Arrays,
        description: TaskDescription,
        parameters: Any,  # noqa: ANN401
        seed: int,
    ) -> FitResult:
        """Fit to training data; see `study.session.effects.RequestFit` for the arrays."""
        ...

    def load(self, weights: bytes, description: TaskDescription) -> Any:  # noqa: ANN401
        """Return the policy or scorer that ``weights`` describe."""
        ...
