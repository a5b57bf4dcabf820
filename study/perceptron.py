"""Small ReLU networks as NumPy arrays: their forward pass, and reading them with care."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from safetensors import SafetensorError, safe_open

from study.errors import StudyError

MAX_BYTES = 4_000_000
MAX_TENSORS = 64

Floats = npt.NDArray[np.float64]
Layers = Sequence[tuple[npt.NDArray[np.floating], npt.NDArray[np.floating]]]
Tensors = Mapping[str, npt.NDArray[Any]]


def forward(layers: Layers, features: Floats) -> Floats:
    """Return the outputs float64 [..., out] of layers with ReLU between them.

    Args:
        layers: (weight [out, in], bias [out]) pairs.
        features: float64 [..., in].
    """
    values = features
    *hidden, (weight, bias) = layers
    for inner_weight, inner_bias in hidden:
        values = np.maximum(values @ inner_weight.T + inner_bias, 0.0)
    outputs: Floats = values @ weight.T + bias
    return outputs


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Perceptron:
    """A multilayer perceptron with ReLU between its layers.

    Attributes:
        layers: (weight [out, in], bias [out]) pairs, float64.
    """

    layers: tuple[tuple[Floats, Floats], ...]

    def __call__(self, features: Floats) -> Floats:
        """Return the outputs float64 [..., out] for features [..., in]."""
        return forward(self.layers, features)

    def tensors(self, name: str) -> dict[str, npt.NDArray[np.float32]]:
        """Return the layers by tensor name, to be saved."""
        found: dict[str, npt.NDArray[np.float32]] = {}
        for number, (weight, bias) in enumerate(self.layers):
            found[f"{name}.layer{number}.weight"] = weight.astype(np.float32)
            found[f"{name}.layer{number}.bias"] = bias.astype(np.float32)
        return found

    @classmethod
    def from_tensors(cls, tensors: Tensors, name: str, inputs: int, outputs: int) -> Perceptron:
        """Build the network that `tensors` names, and check that it fits together.

        Raises:
            ValueError: a layer is missing, has the wrong shape or type, or holds a number
                that is not finite.
        """
        layers: list[tuple[Floats, Floats]] = []
        width = inputs
        while f"{name}.layer{len(layers)}.weight" in tensors:
            weight = tensors[f"{name}.layer{len(layers)}.weight"]
            bias = tensors.get(f"{name}.layer{len(layers)}.bias")
            if bias is None or weight.ndim != 2 or weight.shape[1] != width:
                raise ValueError(f"layer {len(layers)} of {name} does not fit")
            if bias.shape != weight.shape[:1] or {weight.dtype.kind, bias.dtype.kind} != {"f"}:
                raise ValueError(f"layer {len(layers)} of {name} does not fit")
            if not (np.isfinite(weight).all() and np.isfinite(bias).all()):
                raise ValueError(f"layer {len(layers)} of {name} holds a number that is not finite")
            layers.append((weight.astype(np.float64), bias.astype(np.float64)))
            width = weight.shape[0]
        if not layers or width != outputs:
            raise ValueError(f"{name} has no layers or not {outputs} outputs")
        return cls(tuple(layers))


def read_weights(path: Path) -> tuple[dict[str, npt.NDArray[Any]], dict[str, str]]:
    """Read a small safetensors file: its tensors and its metadata.

    Raises:
        StudyError: it cannot be read, is too large or is no safetensors file.
    """
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise StudyError(f"{path}: {size} bytes; weights have at most {MAX_BYTES}")
        with safe_open(path, "numpy") as file:
            names = list(file.keys())
            if len(names) > MAX_TENSORS:
                raise StudyError(f"{path}: {len(names)} tensors; there are at most {MAX_TENSORS}")
            return {name: file.get_tensor(name) for name in names}, dict(file.metadata() or {})
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (SafetensorError, ValueError, TypeError, KeyError) as error:
        raise StudyError(f"{path}: no readable safetensors file: {error}") from error
