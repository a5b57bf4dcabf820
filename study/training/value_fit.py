"""Fitting a network to lambda-returns: values by temporal differences."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import torch
from pydantic import BaseModel, ConfigDict, Field

from study.perceptron import Perceptron
from study.seeding import generator, stream_seed
from study.simulated.landmarks import Landmarks
from study.simulated.rollouts import Rollouts
from study.simulated.values import FittedValues, lambda_returns


class ValueParameters(BaseModel):
    """How values are fitted."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    discount: float = Field(0.99, gt=0, lt=1, description="gamma, per timestep")
    trace: float = Field(
        1.0, ge=0, le=1, description="lambda; below 1 the fit bootstraps and may fail silently"
    )
    hidden: tuple[int, ...] = Field(
        (64, 64), description="units of each hidden ReLU layer; values are asked of whole fleets"
    )
    rounds: int = Field(
        10, ge=1, description="times that returns are computed anew from the fit; 1 if trace is 1"
    )
    epochs: int = Field(12, ge=1, description="passes over the states in each round")
    batch_size: int = Field(512, ge=1, description="states in a minibatch")
    learning_rate: float = Field(0.003, gt=0, description="Adam's step size at the start")


def fit_values(
    rollouts: Rollouts,
    landmarks: Landmarks,
    parameters: ValueParameters,
    seed: int,
) -> FittedValues:
    """Fit V of the policy that drove, by TD(lambda).

    Whoever fits holds it against other rollouts; see `study.simulated.values`.

    Args:
        rollouts: what is learned from; starts should be spread over all states of interest.
        landmarks: what turns states into features.
        parameters: of the fit.
        seed: of initial weights and minibatches.
    """
    torch.set_num_threads(1)
    where = rollouts.running
    features = landmarks.features(rollouts.states[:-1][where])
    inputs = torch.from_numpy(features).float()
    module = _module(inputs.shape[1], parameters.hidden, stream_seed(seed, "value_weights"))
    random = generator(seed, "value_batches")
    fitted: FittedValues | None = None
    for _ in range(1 if parameters.trace == 1.0 else parameters.rounds):
        returns = lambda_returns(rollouts, parameters.discount, parameters.trace, fitted)[where]
        mean, deviation = float(returns.mean()), float(returns.std()) or 1.0
        targets = torch.from_numpy((returns - mean) / deviation).float()
        _regress(module, inputs, targets, parameters, random)
        fitted = FittedValues(_layers(module), landmarks, mean, deviation)
    assert fitted is not None  # noqa: S101 - there is at least one round
    return fitted


def _module(inputs: int, hidden: Sequence[int], seed: int) -> torch.nn.Sequential:
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        parts: list[torch.nn.Module] = []
        for before, after in itertools.pairwise((inputs, *hidden, 1)):
            parts += [torch.nn.Linear(before, after), torch.nn.ReLU()]
    return torch.nn.Sequential(*parts[:-1])


def _regress(
    module: torch.nn.Module,
    features: torch.Tensor,
    targets: torch.Tensor,
    parameters: ValueParameters,
    random: np.random.Generator,
) -> None:
    """Least squares by minibatch Adam with a step size that falls to zero."""
    optimiser = torch.optim.Adam(module.parameters(), lr=parameters.learning_rate, fused=True)
    for epoch in range(parameters.epochs):
        falling = 0.5 * (1 + math.cos(math.pi * epoch / parameters.epochs))
        optimiser.param_groups[0]["lr"] = parameters.learning_rate * falling
        order = torch.from_numpy(random.permutation(len(targets)))
        for rows in torch.split(order, parameters.batch_size):
            optimiser.zero_grad()
            loss = torch.nn.functional.mse_loss(module(features[rows])[:, 0], targets[rows])
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()


def _layers(module: torch.nn.Sequential) -> Perceptron:
    return Perceptron(
        tuple(
            (part.weight.detach().double().numpy(), part.bias.detach().double().numpy())
            for part in module
            if isinstance(part, torch.nn.Linear)
        )
    )
