"""Fitting a network to choices. Imports torch, so it is imported by a fit only."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from study.events.task_description import StateField
from study.features import encode, standardisation
from study.policies.base import FitResult
from study.scorers._choices import Choices, fit_metrics, held_out_rows
from study.scorers._network import Network, NetworkParameters

Loss = Callable[[torch.Tensor, torch.Tensor, torch.Tensor], torch.Tensor]
"""Mean loss of scores [b, n] given available bool [b, n] and chosen int64 [b]."""

_MINIBATCHES = 12
"""Least number of minibatches in a pass: few choices would else get too few steps."""


def fit_network(
    choices: Choices,
    fields: Sequence[StateField],
    parameters: NetworkParameters,
    seed: int,
    loss: Loss,
) -> FitResult:
    """Fit to all choices; measure on held-out trials what a fit to the others achieves.

    Args:
        choices: the data.
        fields: the state's fields.
        parameters: architecture and optimisation.
        seed: of initial weights, minibatches and held-out trials.
        loss: what is minimised.
    """
    metrics = {
        "choices": float(len(choices)),
        "trials": float(len(np.unique(choices.trials))),
    }
    held_out = held_out_rows(choices, parameters.held_out_fraction, _random(seed))
    if held_out is not None:
        network = _trained(choices.rows(~held_out), fields, parameters, seed, loss)
        unseen = choices.rows(held_out)
        measures = fit_metrics(network.scores(unseen.states), unseen)
        metrics |= {f"held_out_{name}": value for name, value in measures.items()}
        metrics["held_out_choices"] = float(len(unseen))
    network = _trained(choices, fields, parameters, seed, loss)
    metrics |= fit_metrics(network.scores(choices.states), choices)
    return FitResult(weights=network.to_bytes(), metrics=metrics)


def _random(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))


def _trained(
    choices: Choices,
    fields: Sequence[StateField],
    parameters: NetworkParameters,
    seed: int,
    loss: Loss,
) -> Network:
    standard = standardisation(choices.states[choices.available], fields)
    features = encode(choices.states, fields, standard=standard)
    linear = not parameters.hidden
    dtype = torch.float64 if linear else torch.float32
    tensors = (
        torch.from_numpy(features).to(dtype),
        torch.from_numpy(choices.available),
        torch.from_numpy(choices.chosen),
    )
    module = _module(features.shape[-1], parameters.hidden, seed).to(dtype)
    if linear:
        _minimise_convex(module, tensors, loss)
    else:
        _minimise(module, tensors, loss, parameters, seed)
    return Network(_layers(module), standard, fields)


def _module(inputs: int, hidden: tuple[int, ...], seed: int) -> torch.nn.Sequential:
    """Return a perceptron; a linear one starts at zero, others at torch's default."""
    widths = (inputs, *hidden, 1)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        parts: list[torch.nn.Module] = []
        for before, after in itertools.pairwise(widths):
            parts += [torch.nn.Linear(before, after), torch.nn.ReLU()]
    if not hidden:
        for weights in parts[0].parameters():
            torch.nn.init.zeros_(weights)
    return torch.nn.Sequential(*parts[:-1])


def _minimise(
    module: torch.nn.Module,
    tensors: tuple[torch.Tensor, torch.Tensor, torch.Tensor],
    loss: Loss,
    parameters: NetworkParameters,
    seed: int,
) -> None:
    """Minibatch Adam with a step size that falls to zero along a half cosine."""
    random = _random(seed)
    count = len(tensors[0])
    size = min(parameters.batch_size, math.ceil(count / _MINIBATCHES))
    optimiser = torch.optim.AdamW(
        module.parameters(),
        lr=parameters.learning_rate,
        weight_decay=parameters.weight_decay,
        fused=True,
    )
    for epoch in range(parameters.epochs):
        falling = 0.5 * (1 + math.cos(math.pi * epoch / parameters.epochs))
        optimiser.param_groups[0]["lr"] = parameters.learning_rate * falling
        order = torch.from_numpy(random.permutation(count))
        shuffled = [tensor[order] for tensor in tensors]
        for features, available, chosen in zip(
            *(torch.split(tensor, size) for tensor in shuffled), strict=True
        ):
            optimiser.zero_grad()
            loss(module(features)[..., 0], available, chosen).backward()  # type: ignore[no-untyped-call]
            optimiser.step()


def _minimise_convex(
    module: torch.nn.Module,
    tensors: tuple[torch.Tensor, torch.Tensor, torch.Tensor],
    loss: Loss,
) -> None:
    """L-BFGS on all data to convergence: the exact maximum of a linear scorer's likelihood.

    With choices that a linear score explains perfectly there is no maximum: the weights
    then grow until the loss no longer falls.
    """
    features, available, chosen = tensors
    optimiser = torch.optim.LBFGS(
        module.parameters(),
        max_iter=500,
        tolerance_grad=1e-12,
        tolerance_change=1e-16,
        history_size=20,
        line_search_fn="strong_wolfe",
    )

    def evaluate() -> torch.Tensor:
        optimiser.zero_grad()
        value = loss(module(features)[..., 0], available, chosen)
        value.backward()  # type: ignore[no-untyped-call]
        return value

    # A line search can stall on rounding; beginning anew forgets its curvature history.
    for _ in range(3):
        optimiser.state.clear()
        optimiser.step(evaluate)  # type: ignore[no-untyped-call]


def _layers(
    module: torch.nn.Sequential,
) -> tuple[tuple[npt.NDArray[Any], npt.NDArray[Any]], ...]:
    return tuple(
        (part.weight.detach().numpy(), part.bias.detach().numpy())
        for part in module
        if isinstance(part, torch.nn.Linear)
    )
