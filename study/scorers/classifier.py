"""A classifier of chosen against not chosen: what Luce's model is compared with.

It takes every robot for an independent yes or no and forgets what else there was to
choose from. Its score is the logit, whose order is that of the sigmoid's probability.
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
    """Fit by binary cross-entropy over all available robots.

    Args:
        arrays: ``states`` float32 [m, n, d], ``available`` bool [m, n], ``chosen`` int32 [m],
            ``trials`` int32 [m].
        description: the task's.
        parameters: as in a protocol.
        seed: of initial weights, minibatches and held-out trials.
        start: preparation of an earlier fit with the same seed to go on from; empty for none.

    Returns:
        Weights and metrics; the metrics' likelihood is Luce's with the logits as scores.

    Raises:
        StudyError: the choices cannot be fitted; the message says why.
    """
    settings = Parameters.model_validate(parameters)
    choices = validated_choices(arrays)
    from study.scorers._training import fit_network  # noqa: PLC0415

    return fit_network(
        choices, description.state_fields, settings, seed, binary_cross_entropy, start
    )


def load(weights: bytes, description: TaskDescription) -> Network:
    """Return the scorer that `fit` made."""
    return Network.from_bytes(weights, description)


def binary_cross_entropy(
    scores: torch.Tensor, available: torch.Tensor, chosen: torch.Tensor
) -> torch.Tensor:
    """Return the mean binary cross-entropy over the available robots, in nats a robot.

    Args:
        scores: [b, n], logits.
        available: bool [b, n]; the others do not count.
        chosen: int64 [b].
    """
    picked = scores.gather(1, chosen[:, None])[:, 0]
    losses = scores.clamp(min=0) + (-scores.abs()).exp().log1p()
    return ((losses * available).sum() - picked.sum()) / available.sum()
