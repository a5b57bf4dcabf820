"""Luce's choice model: the paper's scorer, fitted by maximum likelihood.

Robot i of those available is chosen with probability exp(phi(s_i)) / sum_j exp(phi(s_j)).
phi is identified up to a constant.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from study.events.task_description import TaskDescription
from study.policies.base import Arrays, FitResult
from study.scorers._choices import validated_choices
from study.scorers._network import Network, NetworkParameters

if TYPE_CHECKING:
    import torch

WARM_STARTS = True


class Parameters(NetworkParameters):
    """What a protocol can set of the scorer."""


def fit(
    arrays: Arrays,
    description: TaskDescription,
    parameters: Mapping[str, object] | Parameters,
    seed: int,
    start: bytes = b"",
) -> FitResult:
    """Fit phi by maximum likelihood to the operator's choices.

    Args:
        arrays: ``states`` float32 [m, n, d], ``available`` bool [m, n], ``chosen`` int32 [m],
            ``trials`` int32 [m].
        description: the task's.
        parameters: as in a protocol.
        seed: of initial weights, minibatches and held-out trials.
        start: preparation of an earlier fit with the same seed to go on from; empty for none.

    Raises:
        StudyError: the choices cannot be fitted; the message says why.
    """
    settings = Parameters.model_validate(parameters)
    choices = validated_choices(arrays)
    from study.scorers._training import fit_network  # noqa: PLC0415

    return fit_network(
        choices, description.state_fields, settings, seed, negative_log_likelihood, start
    )


def load(weights: bytes, description: TaskDescription) -> Network:
    """Return the scorer that `fit` made."""
    return Network.from_bytes(weights, description)


def negative_log_likelihood(
    scores: torch.Tensor, available: torch.Tensor, chosen: torch.Tensor
) -> torch.Tensor:
    """Return the mean negative log-likelihood of the choices, in nats a choice.

    Args:
        scores: [b, n].
        available: bool [b, n]; the others have no part in the softmax.
        chosen: int64 [b].
    """
    masked = scores.masked_fill(~available, -float("inf"))
    picked = masked.gather(1, chosen[:, None])[:, 0]
    return (masked.logsumexp(dim=1) - picked).mean()
