"""Power without simulation, where the primary test is that of the participants' means.

With two conditions the square of the paired t has a doubly noncentral F distribution: the mean of
the differences lies off zero by the effect, and their scatter holds what order adds, since the
test does not adjust for it. The denominator is a Poisson mixture of central chi-squares (Johnson,
Kotz & Balakrishnan 1995, Continuous Univariate Distributions 2, chapter 30). Participants left out
make a binomial mixture over those who stay. This is exact.

With more conditions it is the noncentral F before Greenhouse and Geisser's correction: near, as
made-up studies are spherical, but not exact.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from analysis.planning.assumptions import Assumptions, Design
from analysis.statistics.pairs import SMALLEST_N

Floats = npt.NDArray[np.float64]
Numbers = float | npt.NDArray[np.floating[Any]]
NEGLIGIBLE = 1e-12
"""Probability that is left out at each end of a mixture."""


@dataclasses.dataclass(frozen=True, slots=True)
class ClosedForm:
    """Power by a formula.

    Attributes:
        power: the probability that the test finds something.
        exact: whether it is that of the very test; else an approximation.
    """

    power: float
    exact: bool


def closed_form(given: Assumptions, design: Design) -> ClosedForm | None:
    """Return the power of a design; None where there is no formula.

    There is none where the mixed model of the trials takes the place of the test of means, and
    with three or more conditions whose order matters.
    """
    if not given.always_means:
        return None
    whole = given.conditions * design.trials
    stays = (1 - given.drop_out) * (1 - given.missing) ** whole
    if given.conditions > 2:
        if np.any(given.shifts()):
            return None
        return ClosedForm(_several(given, design, stays), exact=False)
    return ClosedForm(_two(given, design, stays), exact=True)


def _several(given: Assumptions, design: Design, stays: float) -> float:
    c = given.conditions
    sizes, chances = _binomial(design.participants, stays)
    spread = float(np.sum((np.array(given.effects) - np.mean(given.effects)) ** 2))
    centre = sizes * spread / (given.difference_variance(design.trials) / 2)
    df2 = (c - 1) * (sizes - 1.0)
    usable = sizes >= SMALLEST_N
    limit = stats.f.isf(given.alpha, c - 1, df2[usable])
    power = _beyond(limit, c - 1.0, df2[usable], centre[usable])
    return float(chances[usable] @ power)


def _two(given: Assumptions, design: Design, stays: float) -> float:
    """Sum over how many of each order stay."""
    shifts = given.shifts()
    centres = given.effects[1] - given.effects[0] + shifts[:, 1] - shifts[:, 0]
    if np.ptp(centres) == 0:
        centres, groups = centres[:1], [design.participants]
    else:
        turns = np.arange(design.participants) % len(centres)
        groups = [int(np.sum(turns == turn)) for turn in range(len(centres))]
    variance = given.difference_variance(design.trials)
    each = [_binomial(count, stays) for count in groups]
    total = 0.0
    for parts in itertools.product(*(zip(*pair, strict=True) for pair in each)):
        sizes = np.array([size for size, _ in parts], dtype=np.float64)
        chance = math.prod(float(chance) for _, chance in parts)
        if sizes.sum() >= SMALLEST_N and chance > NEGLIGIBLE:
            total += chance * _doubly(sizes, centres, variance, given.alpha)
    return total


def _doubly(sizes: Floats, centres: Floats, variance: float, alpha: float) -> float:
    """Return P(t squared > limit) for groups of these sizes about these centres."""
    n = float(sizes.sum())
    mean = float(sizes @ centres) / n
    above = n * mean**2 / variance
    below = float(sizes @ (centres - mean) ** 2) / variance
    limit = float(stats.f.isf(alpha, 1, n - 1))
    low, high = stats.poisson.interval(1 - NEGLIGIBLE, below / 2) if below else (0.0, 0.0)
    terms = np.arange(max(0, int(low) - 1), int(high) + 2) if below else np.zeros(1)
    weights = stats.poisson.pmf(terms, below / 2)
    df2 = n - 1 + 2 * terms
    power = _beyond(limit * df2 / (n - 1), 1.0, df2, above)
    return float(weights @ power)


def _beyond(limit: Numbers, df1: Numbers, df2: Numbers, centre: Numbers) -> Floats:
    """Return P(F > limit) of noncentral F."""
    # SciPy's is 0 at a centre of zero.
    off = np.asarray(stats.ncf.sf(limit, df1, df2, centre), dtype=np.float64)
    return np.clip(np.where(np.asarray(centre) > 0, off, stats.f.sf(limit, df1, df2)), 0.0, 1.0)


def _binomial(count: int, chance: float) -> tuple[npt.NDArray[np.int64], Floats]:
    """Return how many of some stay, and with which probability, without what hardly happens."""
    sizes = np.arange(count + 1)
    chances = stats.binom.pmf(sizes, count, chance)
    likely = chances > NEGLIGIBLE
    return sizes[likely], chances[likely]


def smallest_participants(
    given: Assumptions, trials: int, power: float, step: int, most: int
) -> int | None:
    """Return the fewest participants, a multiple of a step, with a power; None up to a limit.

    Where there is no formula it is that of those who stay, with complete data, and with three or
    more conditions as if order did not matter.
    """
    plain = given if given.always_means else dataclasses.replace(given, needed=1.0, missing=0.0)
    if plain.conditions > 2:
        plain = dataclasses.replace(plain, period=0.0, carry_over=0.0)
    counts = range(step * math.ceil(SMALLEST_N / step), most + 1, step)
    low, high = 0, len(counts)
    while low < high:
        middle = (low + high) // 2
        found = closed_form(plain, Design(counts[middle], trials))
        if found is not None and found.power >= power:
            high = middle
        else:
            low = middle + 1
    return counts[low] if low < len(counts) else None
