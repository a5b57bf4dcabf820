"""States to features: the one encoding that policies and scorers share."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from study.events.task_description import StateField

Encoding = Literal["sine_cosine", "scaled", "raw"]
Floats = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Standardisation:
    """What is subtracted from and divided out of the fields that are not circular.

    Attributes:
        mean: float64 [d]; 0 for circular fields.
        deviation: float64 [d], positive; 1 for circular fields.
    """

    mean: Floats
    deviation: Floats


def standardisation(
    states: npt.NDArray[np.float32], fields: Sequence[StateField]
) -> Standardisation:
    """Return mean and standard deviation of the fields over training states.

    A field that does not vary has deviation 1: it says nothing and must not divide by zero.

    Args:
        states: [m, d], m at least 1.
        fields: the state's d fields.
    """
    values = states.astype(np.float64)
    circular = np.array([field.circular for field in fields])
    deviation = values.std(axis=0)
    constant = deviation <= 1e-9 * np.maximum(1.0, np.abs(values).max(axis=0))
    return Standardisation(
        mean=np.where(circular, 0.0, values.mean(axis=0)),
        deviation=np.where(circular | constant, 1.0, deviation),
    )


@functools.lru_cache(maxsize=16)
def range_standardisation(fields: tuple[StateField, ...]) -> Standardisation:
    """Return what maps each field's range to -1 to 1, whatever the data.

    Args:
        fields: the state's d fields.
    """
    circular = np.array([field.circular for field in fields])
    low = np.array([field.low for field in fields])
    high = np.array([field.high for field in fields])
    return Standardisation(
        mean=np.where(circular, 0.0, (low + high) / 2),
        deviation=np.where(circular, 1.0, (high - low) / 2),
    )


def encode(
    states: npt.NDArray[np.float32],
    fields: Sequence[StateField],
    encoding: Encoding = "sine_cosine",
    standard: Standardisation | None = None,
) -> Floats:
    """Encode states as features.

    "sine_cosine" gives a circular field as sine and cosine. If ``standard`` is given, the
    other fields are standardised. Else they are scaled by their range to 0 to 1, and sine
    and cosine lie on a circle of circumference 1, so that a small change of a circular
    field counts as much as the same part of any other field's range.
    "scaled" scales every field by its range. "raw" leaves them alone.

    Args:
        states: [..., d].
        fields: the state's d fields.
        encoding: how.
        standard: mean and deviation, for "sine_cosine".

    Returns:
        float64 [..., k]; k is d, or d plus the number of circular fields for "sine_cosine".
    """
    values = states.astype(np.float64)
    if encoding == "raw":
        return values
    layout = _layout(tuple(fields))
    if encoding == "scaled":
        scaled: Floats = (values - layout.low) / layout.span
        return scaled
    low, span, radius = layout.low, layout.span, 1 / (2 * np.pi)
    if standard is not None:
        low, span, radius = standard.mean, standard.deviation, 1.0
    features = np.empty((*values.shape[:-1], layout.size))
    plain = layout.plain
    features[..., layout.plain_columns] = (values[..., plain] - low[plain]) / span[plain]
    angles = values[..., layout.circular] * layout.turns
    features[..., layout.sine_columns] = radius * np.sin(angles)
    features[..., layout.cosine_columns] = radius * np.cos(angles)
    return features


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Layout:
    """Where each field goes among the features of "sine_cosine"."""

    low: Floats
    span: Floats
    plain: list[int]
    circular: list[int]
    turns: Floats
    plain_columns: list[int]
    sine_columns: list[int]
    cosine_columns: list[int]
    size: int


@functools.lru_cache(maxsize=16)
def _layout(fields: tuple[StateField, ...]) -> _Layout:
    low = np.array([field.low for field in fields])
    span = np.array([field.high for field in fields]) - low
    circular = [place for place, field in enumerate(fields) if field.circular]
    # A circular field takes two columns, and moves all that follow it by one.
    columns = [place + sum(c < place for c in circular) for place in range(len(fields))]
    plain = [place for place in range(len(fields)) if place not in circular]
    return _Layout(
        low=low,
        span=span,
        plain=plain,
        circular=circular,
        turns=2 * np.pi / span[circular],
        plain_columns=[columns[place] for place in plain],
        sine_columns=[columns[place] for place in circular],
        cosine_columns=[columns[place] + 1 for place in circular],
        size=len(fields) + len(circular),
    )


def feature_names(fields: Sequence[StateField]) -> tuple[str, ...]:
    """Return the names of the features that "sine_cosine" gives, in order."""
    names: list[str] = []
    for field in fields:
        names += [f"sin {field.name}", f"cos {field.name}"] if field.circular else [field.name]
    return tuple(names)


def standardised_columns(fields: Sequence[StateField]) -> dict[int, int]:
    """Return which features of "sine_cosine" are standardised: column to field of the state."""
    layout = _layout(tuple(fields))
    return dict(zip(layout.plain_columns, layout.plain, strict=True))
