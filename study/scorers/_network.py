"""The network that scorers share, as NumPy: no torch is needed to score."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import safetensors.numpy
from pydantic import BaseModel, ConfigDict, Field

from study.events.task_description import StateField, TaskDescription
from study.features import Standardisation, encode
from study.perceptron import forward

Floats = npt.NDArray[np.float64]


class NetworkParameters(BaseModel):
    """What a protocol can set of a fitted scorer."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    hidden: tuple[Annotated[int, Field(ge=1, le=1024)], ...] = Field(
        (32, 32),
        max_length=8,
        description="units of each hidden ReLU layer; [] gives a linear scorer, fitted to "
        "convergence (the next four do not apply to it)",
    )
    learning_rate: float = Field(0.02, gt=0, description="Adam's step size at the start")
    epochs: int = Field(30, ge=1, description="passes over the choices")
    batch_size: int = Field(
        128, ge=1, description="choices in a minibatch; fewer where a pass would have under 12"
    )
    weight_decay: float = Field(0.1, ge=0, description="decoupled weight decay")
    warm_epochs: int = Field(
        2,
        ge=1,
        description="passes over the choices of a fit that goes on from one made in the "
        "background before the last trial",
    )
    held_out_fraction: float = Field(
        0.2,
        ge=0,
        le=0.5,
        description="part of the trials held out to measure the fit (every k-th, k being its "
        "reciprocal); the weights kept are then fitted to all. Needs three trials",
    )
    held_out_parts: int = Field(
        1,
        ge=1,
        le=20,
        description="how many such parts are held out in turn, each by a fit of its own; all "
        "of them together are every trial",
    )


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A multilayer perceptron with ReLU, its input scaling included.

    Attributes:
        layers: (weight [out, in], bias [out]) pairs; the last has one output.
        standard: the input's mean and deviation.
        fields: the state's fields.
    """

    layers: tuple[tuple[npt.NDArray[np.floating], npt.NDArray[np.floating]], ...]
    standard: Standardisation
    fields: Sequence[StateField]

    def scores(self, states: npt.NDArray[np.float32]) -> Floats:
        """Return a score for each state, computed in float64.

        Args:
            states: float32 [..., d].

        Returns:
            float64 [...].
        """
        values = encode(states, self.fields, standard=self.standard)
        scores: Floats = forward(self.layers, values)[..., 0]
        return scores

    def to_bytes(self) -> bytes:
        """Encode as safetensors."""
        return safetensors.numpy.save(self.tensors())

    def tensors(self) -> dict[str, npt.NDArray[np.floating]]:
        """Return weights and input scaling by name."""
        tensors: dict[str, npt.NDArray[np.floating]] = {
            "input.mean": self.standard.mean,
            "input.deviation": self.standard.deviation,
        }
        for number, (weight, bias) in enumerate(self.layers):
            tensors[f"layer{number}.weight"] = weight
            tensors[f"layer{number}.bias"] = bias
        return tensors

    @classmethod
    def from_bytes(cls, weights: bytes, description: TaskDescription) -> Network:
        """Decode what `to_bytes` wrote."""
        return cls.from_tensors(safetensors.numpy.load(weights), description.state_fields)

    @classmethod
    def from_tensors(
        cls, tensors: Mapping[str, npt.NDArray[Any]], fields: Sequence[StateField]
    ) -> Network:
        """Return the network of `tensors`."""
        depth = sum(name.endswith(".weight") for name in tensors)
        layers = [(f"layer{number}.weight", f"layer{number}.bias") for number in range(depth)]
        return cls(
            layers=tuple(
                (tensors[weight].astype(np.float64), tensors[bias].astype(np.float64))
                for weight, bias in layers
            ),
            standard=Standardisation(tensors["input.mean"], tensors["input.deviation"]),
            fields=fields,
        )
