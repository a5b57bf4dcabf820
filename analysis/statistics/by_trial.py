"""Means over choices whose interval is made of trials: choices of one trial resemble each other."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.stats import t

from analysis.statistics.result import Interval

FEWEST_TRIALS = 3
"""Trials under which there is no interval: t with one degree of freedom reaches 12.7 errors."""


def mean_over_trials(
    means: npt.NDArray[np.float64], choices: npt.NDArray[np.float64], level: float = 0.95
) -> tuple[float, Interval | None]:
    """Return the mean over all choices, with an interval that takes a trial for one observation.

    The variance is that of a ratio estimator over clusters (Cochran, Sampling Techniques, 1977,
    section 9A.2); t with one degree of freedom less than there are trials.

    Args:
        means: float64 [k], mean of each trial's choices.
        choices: float64 [k], how many there are; at least 1 in all.
        level: of the interval.

    Returns:
        The mean, and the interval; None with fewer than three trials.
    """
    total, count = float(choices.sum()), len(choices)
    mean = float((means * choices).sum()) / total
    if count < FEWEST_TRIALS:
        return mean, None
    deviations = choices * (means - mean)
    error = math.sqrt(count / (count - 1) * float((deviations**2).sum())) / total
    reach = float(t.ppf((1 + level) / 2, count - 1)) * error
    return mean, Interval(mean - reach, mean + reach, level)
