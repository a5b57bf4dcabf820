"""The input of the user's networks: what a state is, at several scales.

A small network on plain coordinates is slow to learn what is small on the map: a health pack
counts for little until its edge is seen. So each field that is not circular also comes as sines
and cosines of doubling frequency over its range (Fourier features; Tancik et al., 2020).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.task_description import StateField
from study.features import encode, range_standardisation

OCTAVES = 4
"""Frequencies used: the shortest wave is an eighth of a field's range."""


def wave_features(
    states: npt.NDArray[np.float32], fields: tuple[StateField, ...], octaves: int = OCTAVES
) -> npt.NDArray[np.float64]:
    """Return features of states.

    Args:
        states: float32 [..., d].
        fields: the state's d fields.
        octaves: how many frequencies, from one wave in a range upwards.

    Returns:
        float64 [..., k]: the fields, in -1 to 1 over their range and circular ones as sine and
        cosine; then for each frequency the sines and cosines of those that are not circular.
    """
    standard = range_standardisation(fields)
    plain = [place for place, field in enumerate(fields) if not field.circular]
    scaled = (states[..., plain].astype(np.float64) - standard.mean[plain]) / standard.deviation[
        plain
    ]
    parts = [encode(states, fields, standard=standard)]
    sine, cosine = np.sin(np.pi * scaled), np.cos(np.pi * scaled)
    for _ in range(octaves):
        parts += [sine, cosine]
        # Doubling the angle is cheaper than another sine.
        sine, cosine = 2 * sine * cosine, 1 - 2 * sine * sine
    return np.concatenate(parts, axis=-1)
