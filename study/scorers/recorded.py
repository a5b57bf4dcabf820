"""Control: a scorer that was fitted to another participant, from that session's recording.

The shell reads the weights and hands them over as data of the fit, so this module opens no file.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.policies.base import Arrays, FitResult
from study.scorers._network import Network

IS_CONTROL = True
WEIGHTS = "weights"
"""Name of the array, uint8 [bytes], that holds the other participant's weights."""


class Parameters(BaseModel):
    """What a protocol can set of the scorer."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    recording: str = Field(
        "",
        description="path of the recording, from the protocol's folder; "
        "`--scorer NAME=PATH` overrules it",
    )
    scorer: str = Field("luce", description="its name under that protocol's [scorers]")


def fit(
    arrays: Arrays,
    description: TaskDescription,
    parameters: Mapping[str, object] | Parameters,
    seed: int,  # noqa: ARG001 - nothing is fitted
) -> FitResult:
    """Return the recorded weights, checked against this task.

    Raises:
        StudyError: there are none, or they are of another state.
    """
    Parameters.model_validate(parameters)
    if WEIGHTS not in arrays:
        raise StudyError("no recorded scorer was given", "Give its recording's path.")
    weights = arrays[WEIGHTS].astype(np.uint8).tobytes()
    try:
        scorer = load(weights, description)
        scorer.scores(np.zeros((1, len(description.state_fields)), dtype=np.float32))
    except Exception as error:
        raise StudyError(f"the recorded scorer does not fit this task: {error}") from error
    return FitResult(weights=weights, metrics={})


def load(weights: bytes, description: TaskDescription) -> Network:
    """Return the scorer that was fitted to the other participant."""
    return Network.from_bytes(weights, description)
