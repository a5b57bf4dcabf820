"""Diverging colours for signed values: ColorBrewer's PRGn, and its mirror for dark pages."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

STEPS = 63

_LIGHT_ANCHORS = (
    "762a83",
    "9970ab",
    "c2a5cf",
    "e7d4e8",
    "f7f7f7",
    "d9f0d3",
    "a6dba0",
    "5aae61",
    "1b7837",
)
_DARK_ANCHORS = (
    "d0a3e6",
    "9a63b5",
    "6f4a85",
    "46385a",
    "262b33",
    "2b4a37",
    "35733f",
    "46a352",
    "8fe58f",
)


def _ramp(anchors: tuple[str, ...]) -> npt.NDArray[np.uint8]:
    """Interpolate anchors to an odd number of steps, so that zero has its own colour."""
    colours = np.array([[int(a[i : i + 2], 16) for i in (0, 2, 4)] for a in anchors], dtype=float)
    places = np.linspace(0, len(anchors) - 1, STEPS)
    channels = [np.interp(places, np.arange(len(anchors)), colours[:, c]) for c in range(3)]
    ramp: npt.NDArray[np.uint8] = np.rint(np.stack(channels, axis=1)).astype(np.uint8)
    return ramp


LIGHT_PRGN = _ramp(_LIGHT_ANCHORS)
DARK_PRGN = _ramp(_DARK_ANCHORS)
