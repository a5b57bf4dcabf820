"""What control scorers share: nothing is learned, and what they keep is safetensors like a fit."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import safetensors.numpy

from study.policies.base import FitResult


def settings_only(**numbers: float) -> FitResult:
    """Return a fit that consists of settings: no data were used, so nothing is measured."""
    tensors = {name: np.array([value], dtype=np.float64) for name, value in numbers.items()}
    tensors["control"] = np.array([1.0])
    return FitResult(weights=safetensors.numpy.save(tensors), metrics={})


def setting(weights: bytes, name: str) -> float:
    """Return one number of what `settings_only` wrote."""
    tensors: dict[str, npt.NDArray[np.float64]] = safetensors.numpy.load(weights)
    return float(tensors[name][0])
