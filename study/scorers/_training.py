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
from study.features import Standardisation, encode, standardisation, standardised_columns
from study.policies.base import FitResult
from study.scorers._choices import (
    Choices,
    calibration,
    fit_metrics,
    held_out_parts,
    trial_metrics,
)
from study.scorers._network import Network, NetworkParameters
from study.scorers._warm_start import (
    Trained,
    best_start,
    first_layer_for,
    from_preparation,
    to_preparation,
)

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
    start: bytes = b"",
) -> FitResult:
    """Fit to all choices; measure on held-out trials what a fit to the others achieves.

    Args:
        choices: the data.
        fields: the state's fields.
        parameters: architecture and optimisation.
        seed: of initial weights, minibatches and held-out trials.
        loss: what is minimised.
        start: preparation of an earlier fit to go on from. A fit that is measured on held-out
            trials never goes on from one that has seen any of them.
    """
    candidates = from_preparation(start, fields)
    metrics = {
        "choices": float(len(choices)),
        "trials": float(len(np.unique(choices.trials))),
    }
    made: list[Trained] = []
    warm: list[bool] = []

    def trained(part: Choices) -> Network:
        network, is_warm = _trained(part, fields, parameters, seed, loss, candidates)
        made.append(Trained(network, np.unique(part.trials)))
        warm.append(is_warm)
        return network

    parts = held_out_parts(
        choices, parameters.held_out_fraction, parameters.held_out_parts, _random(seed)
    )
    if parts:
        scores = np.zeros(choices.available.shape)
        for part in parts:
            scores[part] = trained(choices.rows(~part)).scores(choices.states[part])
        seen = np.logical_or.reduce(parts)
        metrics |= _held_out(scores[seen], choices.rows(seen))
    network = trained(choices)
    metrics |= fit_metrics(network.scores(choices.states), choices)
    metrics["warm"] = float(all(warm))
    return FitResult(network.to_bytes(), metrics, to_preparation(made))


def _held_out(scores: npt.NDArray[np.float64], unseen: Choices) -> dict[str, float]:
    measures = fit_metrics(scores, unseen) | calibration(scores, unseen)
    measures |= trial_metrics(scores, unseen)
    measures["choices"] = float(len(unseen))
    return {f"held_out_{name}": value for name, value in measures.items()}


def _random(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))


def _trained(
    choices: Choices,
    fields: Sequence[StateField],
    parameters: NetworkParameters,
    seed: int,
    loss: Loss,
    candidates: Sequence[Trained],
) -> tuple[Network, bool]:
    """Return a fitted network, and whether it went on from one of the candidates."""
    standard = standardisation(choices.states[choices.available], fields)
    features = encode(choices.states, fields, standard=standard)
    linear = not parameters.hidden
    dtype = torch.float64 if linear else torch.float32
    tensors = (
        torch.from_numpy(features).to(dtype),
        torch.from_numpy(choices.available),
        torch.from_numpy(choices.chosen),
    )
    widths = (features.shape[-1], *parameters.hidden, 1)
    module = _module(widths, seed).to(dtype)
    # A linear fit ends at the same maximum wherever it starts.
    before = None if linear else best_start(candidates, np.unique(choices.trials), widths)
    if linear:
        _minimise_convex(module, tensors, loss)
    elif before is None:
        _minimise(module, tensors, loss, parameters, seed)
    else:
        _start_from(module, before, standard)
        _minimise(module, tensors, loss, parameters, seed, warm=True)
    return Network(_layers(module), standard, fields), before is not None


def _module(widths: Sequence[int], seed: int) -> torch.nn.Sequential:
    """Return a perceptron; a linear one starts at zero, others at torch's default."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        parts: list[torch.nn.Module] = []
        for before, after in itertools.pairwise(widths):
            parts += [torch.nn.Linear(before, after), torch.nn.ReLU()]
    if len(parts) == 2:
        for weights in parts[0].parameters():
            torch.nn.init.zeros_(weights)
    return torch.nn.Sequential(*parts[:-1])


def _start_from(module: torch.nn.Sequential, before: Network, standard: Standardisation) -> None:
    """Set weights so that the module computes what a network did, on inputs scaled anew."""
    first = first_layer_for(before, standard, standardised_columns(before.fields))
    linears = [part for part in module if isinstance(part, torch.nn.Linear)]
    with torch.no_grad():
        for part, (weight, bias) in zip(linears, (first, *before.layers[1:]), strict=True):
            part.weight.copy_(torch.from_numpy(np.asarray(weight)))
            part.bias.copy_(torch.from_numpy(np.asarray(bias)))


def _minimise(
    module: torch.nn.Module,
    tensors: tuple[torch.Tensor, torch.Tensor, torch.Tensor],
    loss: Loss,
    parameters: NetworkParameters,
    seed: int,
    *,
    warm: bool = False,
) -> None:
    """Minibatch Adam with a step size that falls to zero along a half cosine.

    What goes on from an earlier fit takes part of the way only, at the step size that is left
    at that point of the whole way.
    """
    random = _random(seed)
    epochs = max(parameters.epochs, parameters.warm_epochs) if warm else parameters.epochs
    first = epochs - parameters.warm_epochs if warm else 0
    count = len(tensors[0])
    size = min(parameters.batch_size, math.ceil(count / _MINIBATCHES))
    optimiser = torch.optim.AdamW(
        module.parameters(),
        lr=parameters.learning_rate,
        weight_decay=parameters.weight_decay,
        fused=True,
    )
    for epoch in range(first, epochs):
        falling = 0.5 * (1 + math.cos(math.pi * epoch / epochs))
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
