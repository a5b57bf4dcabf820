"""The JZS Bayes factor of a paired difference against none."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy import integrate

from analysis.statistics.cells import Cells
from analysis.statistics.pairs import differences
from analysis.statistics.result import Excluded, Refusal

MEDIUM = math.sqrt(2) / 2


@dataclasses.dataclass(frozen=True, slots=True)
class BayesFactor:
    """How much better the data fit a difference than none.

    Attributes:
        name: what the tables call it.
        bf10: of a difference against none; its inverse is of none against a difference.
        log_bf10: its natural logarithm, which does not overflow.
        scale: of the Cauchy prior on the standardised difference.
        rows, participants, excluded: as in EffectResult.
    """

    name: str
    bf10: float
    log_bf10: float
    scale: float
    rows: int
    participants: tuple[str, ...]
    excluded: tuple[Excluded, ...] = ()


def paired_bayes_factor(
    cells: Cells, scale: float = MEDIUM, name: str = "Bayes factor (JZS)"
) -> BayesFactor | Refusal:
    """Compute BF10 of the paired difference with a Cauchy prior on the standardised effect.

    Args:
        cells: participant means under two conditions.
        scale: of the prior; BayesFactor's "medium" is sqrt(2) / 2.
        name: what the tables call it.
    """
    found = differences(cells, name)
    if isinstance(found, Refusal):
        return found
    ordered = np.sort(found)
    t = float(np.mean(ordered)) / (float(np.std(ordered, ddof=1)) / math.sqrt(cells.n))
    log_bf = log_jzs(t, cells.n, scale)
    bf = math.exp(log_bf) if log_bf < 700 else math.inf
    return BayesFactor(name, bf, log_bf, scale, 2 * cells.n, cells.participants, cells.excluded)


def log_jzs(t: float, n: int, scale: float = MEDIUM) -> float:
    """Return log BF10 of a one-sample or paired t statistic, by quadrature over log g.

    Source: Rouder, Speckman, Sun, Morey & Iverson (2009), Psychonomic Bulletin & Review 16,
    225-237, equation 1, with the prior's scale r: g is r^2 times theirs.
    """
    df = n - 1

    def log_integrand(x: float) -> float:
        # x = log g; the inverse-gamma(1/2, 1/2) density of g times dg / dx = g.
        growth = 1 + n * scale**2 * math.exp(x)
        likelihood = -0.5 * math.log(growth) - (df + 1) / 2 * math.log1p(t * t / (growth * df))
        return likelihood - 0.5 * math.log(2 * math.pi) - x / 2 - 0.5 * math.exp(-x)

    grid = np.linspace(-12, 60, 2881)
    values = np.array([log_integrand(float(x)) for x in grid])
    top = int(np.argmax(values))
    peak = float(values[top])
    total, _ = integrate.quad(
        lambda x: math.exp(log_integrand(x) - peak),
        -12,
        60 + 2 * math.log1p(abs(t)),
        points=[float(grid[top])],
        limit=400,
        epsabs=0,
        epsrel=1e-10,
    )
    return math.log(total) + peak + (df + 1) / 2 * math.log1p(t * t / df)
