"""A share of independent trials with its interval."""

from __future__ import annotations

import math

from analysis.statistics.result import Interval

Z = 1.959963984540054
"""The 97.5 % quantile of the standard normal distribution."""


def wilson(share: float, count: int) -> Interval:
    """Return Wilson's 95 % interval of a share (1927, JASA 22, 209-212).

    Args:
        share: of those counted.
        count: how many there were; of none the interval is [0, 1].
    """
    if count == 0:
        return Interval(0.0, 1.0)
    centre = (share + Z * Z / (2 * count)) / (1 + Z * Z / count)
    spread = math.sqrt(share * (1 - share) / count + Z * Z / (4 * count * count))
    reach = Z * spread / (1 + Z * Z / count)
    return Interval(max(0.0, centre - reach), min(1.0, centre + reach))
