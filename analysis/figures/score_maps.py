"""A scorer's values over the map: centred, averaged, with peaks."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from study.events.task_description import MapGrid

LEAST_SHARE = 0.25
"""Local maxima below this share of the highest peak are not marked."""

Floats = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class Peak:
    """A local maximum of the mean map; x and y in metres."""

    x: float
    y: float
    value: float


@dataclasses.dataclass(frozen=True, slots=True)
class ScoreMap:
    """One participant's scorer over the map; cells where no robot can be hold NaN.

    Attributes:
        participant: whose scorer it is.
        mean: over headings and health levels, shape (rows, columns), rows upwards.
        by_heading: mean over health levels, shape (headings, rows, columns).
        by_health: mean over headings, shape (healths, rows, columns).
        peaks: of the mean, the highest first.
    """

    participant: str
    mean: Floats
    by_heading: Floats
    by_health: Floats
    peaks: tuple[Peak, ...]


def score_map(participant: str, flat: Floats, grid: MapGrid, most_peaks: int = 3) -> ScoreMap:
    """Centre a score grid on its mean over free cells and average it.

    A Luce scorer is identified up to a constant only, so that its level means nothing.

    Args:
        participant: whose scorer it is.
        flat: values, flattened from (healths, headings, rows, columns).
        grid: where they were computed.
        most_peaks: at most so many peaks.

    Raises:
        ValueError: the number of values does not fit the grid.
    """
    shape = (len(grid.healths), len(grid.headings), len(grid.ys), len(grid.xs))
    values = np.asarray(flat, dtype=np.float64).reshape(shape)
    free = np.array([[cell == "1" for cell in row] for row in grid.free])
    values = values - values[:, :, free].mean()
    values = np.where(free, values, np.nan)
    mean = values.mean(axis=(0, 1))
    return ScoreMap(
        participant=participant,
        mean=mean,
        by_heading=values.mean(axis=0),
        by_health=values.mean(axis=1),
        peaks=tuple(_peaks(mean, grid)[:most_peaks]),
    )


def shared_limit(maps: Sequence[ScoreMap]) -> float:
    """Return the value at which the colours of all maps end: round, covering nearly all cells."""
    sizes = [np.abs(m.mean[np.isfinite(m.mean)]) for m in maps]
    top = float(np.quantile(np.concatenate(sizes), 0.98)) if sizes else 0.0
    if top <= 0:
        return 1.0
    step = 10.0 ** np.floor(np.log10(top)) / 2
    return float(np.ceil(top / step - 1e-9) * step)


def filled(values: Floats) -> Floats:
    """Give cells without a value that of the nearest cell, so that edges do not fade."""
    missing = np.isnan(values)
    if not missing.any() or missing.all():
        return np.nan_to_num(values)
    places = ndimage.distance_transform_edt(missing, return_distances=False, return_indices=True)
    result: Floats = values[tuple(places)]
    return result


def _peaks(mean: Floats, grid: MapGrid) -> list[Peak]:
    """Find cells above the mean that no cell within two steps exceeds."""
    known = np.where(np.isnan(mean), -np.inf, mean)
    highest = ndimage.maximum_filter(known, size=5, mode="constant", cval=-np.inf)
    found = [
        Peak(grid.xs[column], grid.ys[row], float(known[row, column]))
        for row, column in np.argwhere((known == highest) & (known > 0))
    ]
    found.sort(key=lambda peak: (-peak.value, peak.x, peak.y))
    # Ripples far below the highest peak tell nothing of where somebody would take over.
    found = [peak for peak in found if peak.value >= LEAST_SHARE * found[0].value]
    apart: list[Peak] = []
    reach = 3 * _cell(grid.xs)
    for peak in found:
        # A plateau has many equal cells: one ring stands for them.
        if all(np.hypot(peak.x - p.x, peak.y - p.y) > reach for p in apart):
            apart.append(peak)
    return apart


def _cell(centres: Sequence[float]) -> float:
    return centres[1] - centres[0] if len(centres) > 1 else 1.0
