"""Paired differences of two conditions, or why there is nothing to test."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from analysis.statistics.cells import Cells
from analysis.statistics.result import Refusal

SMALLEST_N = 3


def not_finite(cells: Cells, name: str) -> Refusal | None:
    """Refuse means that are not finite numbers, naming whose they are."""
    bad = np.argwhere(~np.isfinite(cells.means))
    if not len(bad):
        return None
    who, where = cells.participants[bad[0][0]], cells.levels[bad[0][1]]
    reason = f"The mean of {who} under {where} is not a finite number."
    return Refusal(name, reason, cells.excluded)


def constant(values: npt.NDArray[np.float64], scale: float) -> bool:
    """Return whether values are equal but for rounding, beside numbers of that size."""
    return bool(np.ptp(values) <= 1e-12 * max(scale, float(np.abs(values).max())))


def differences(cells: Cells, name: str) -> npt.NDArray[np.float64] | Refusal:
    """Return second minus first condition, shape (n,), or a refusal in words.

    Refused: a number of conditions other than two, fewer than three participants, a mean that
    is not finite, differences without variance.
    """
    if len(cells.levels) != 2:
        return Refusal(
            name,
            f"The test compares two conditions; these data hold {len(cells.levels)}.",
            cells.excluded,
        )
    if cells.n < SMALLEST_N:
        people = "1 participant has" if cells.n == 1 else f"{cells.n} participants have"
        reason = f"{people} data under both conditions; the test needs at least {SMALLEST_N}."
        return Refusal(name, reason, cells.excluded)
    refusal = not_finite(cells, name)
    if refusal is not None:
        return refusal
    found = np.asarray(cells.means[:, 1] - cells.means[:, 0], dtype=np.float64)
    if constant(found, float(np.abs(cells.means).max())):
        reason = (
            "The difference between conditions is the same for every participant, so that it "
            "has no variance to test against."
        )
        return Refusal(name, reason, cells.excluded)
    return found
