"""What a fit leaves for a later one, to more data, to go on from."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import safetensors.numpy
from safetensors import SafetensorError

from study.errors import StudyError
from study.events.task_description import StateField
from study.features import Standardisation
from study.scorers._network import Network

_TRIALS = "trials"


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """A network with the trials that it has seen.

    Attributes:
        network: fitted.
        trials: int64 [k], ids.
    """

    network: Network
    trials: npt.NDArray[np.int64]


def to_preparation(trained: Sequence[Trained]) -> bytes:
    """Encode networks with the trials that each has seen."""
    tensors: dict[str, npt.NDArray[Any]] = {}
    for place, each in enumerate(trained):
        tensors[f"{place}.{_TRIALS}"] = each.trials
        tensors |= {f"{place}.{name}": value for name, value in each.network.tensors().items()}
    return safetensors.numpy.save(tensors)


def from_preparation(preparation: bytes, fields: Sequence[StateField]) -> tuple[Trained, ...]:
    """Decode what `to_preparation` wrote; nothing comes of nothing.

    Raises:
        StudyError: it is something else.
    """
    if not preparation:
        return ()
    try:
        tensors = safetensors.numpy.load(preparation)
        groups: dict[int, dict[str, npt.NDArray[Any]]] = {}
        for name, value in tensors.items():
            place, _, rest = name.partition(".")
            groups.setdefault(int(place), {})[rest] = value
        return tuple(
            Trained(Network.from_tensors(group, fields), group[_TRIALS].astype(np.int64))
            for _, group in sorted(groups.items())
        )
    except (SafetensorError, KeyError, ValueError) as error:
        raise StudyError(f"the fit to go on from cannot be read: {error}") from error


def best_start(
    candidates: Sequence[Trained], trials: npt.NDArray[np.int64], widths: Sequence[int]
) -> Network | None:
    """Return the network that has seen most of some trials and nothing else; None if none has.

    Args:
        candidates: what there is to go on from.
        trials: int64 [k], those that may have been seen: a fit that is measured on others must
            not go on from one that knows them.
        widths: of the input, the hidden layers and the output.
    """
    fitting = [
        each
        for each in candidates
        if len(each.trials) and np.isin(each.trials, trials).all() and _has(each.network, widths)
    ]
    return max(fitting, key=lambda each: len(each.trials)).network if fitting else None


def _has(network: Network, widths: Sequence[int]) -> bool:
    shapes = [weight.shape for weight, _ in network.layers]
    return shapes == [(after, before) for before, after in itertools.pairwise(widths)]


def first_layer_for(
    network: Network, standard: Standardisation, scaled: Mapping[int, int]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return weight and bias of the first layer for inputs that are scaled anew.

    The network computes what it did before: x = mean + deviation * feature in both scalings.

    Args:
        network: as fitted with its own scaling.
        standard: the new scaling.
        scaled: column of the features to field of the state, of the fields that are scaled.
    """
    weight, bias = (np.array(values, dtype=np.float64) for values in network.layers[0])
    before = network.standard
    for column, field in scaled.items():
        old = weight[:, column].copy()
        bias += old * (standard.mean[field] - before.mean[field]) / before.deviation[field]
        weight[:, column] = old * standard.deviation[field] / before.deviation[field]
    return weight, bias
