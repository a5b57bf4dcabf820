"""Two conditions in two orders (AB/BA): condition adjusted for period, period, carry-over.

Source: Hills & Armitage (1979), British Journal of Clinical Pharmacology 8, 7-20. The test of
carry-over compares different people and has little power: it describes, and never decides
which test is run (Freeman 1989, Statistics in Medicine 8, 1421-1432).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from scipy import stats

from analysis.statistics.cells import Cells
from analysis.statistics.pairs import constant, not_finite
from analysis.statistics.result import EffectResult, Interval, Outcome, Refusal

Floats = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class Crossover:
    """The three questions of an AB/BA design.

    Attributes:
        condition: the second condition minus the first, adjusted for period.
        period: the second period minus the first, adjusted for condition.
        carry_over: sum of both means of those who began with the second condition, minus that
            of those who began with the first.
    """

    condition: Outcome
    period: Outcome
    carry_over: Outcome

    @property
    def outcomes(self) -> tuple[Outcome, Outcome, Outcome]:
        """All three, in the order of the tables."""
        return self.condition, self.period, self.carry_over


def crossover(cells: Cells, orders: Mapping[str, tuple[str, ...]]) -> Crossover | Refusal:
    """Test condition, period and carry-over.

    Args:
        cells: participant means under two conditions, the reference first.
        orders: each participant's conditions in the order run.
    """
    name = "Orders (AB/BA)"
    if len(cells.levels) != 2:
        reason = f"The design has two conditions; these data hold {len(cells.levels)}."
        return Refusal(name, reason, cells.excluded)
    refusal = not_finite(cells, name)
    if refusal is not None:
        return refusal
    forward, backward = cells.levels, cells.levels[::-1]
    own = [tuple(orders.get(who, ())) for who in cells.participants]
    first = np.array([order == forward for order in own], dtype=bool)
    second = np.array([order == backward for order in own], dtype=bool)
    if not np.all(first | second):
        who = cells.participants[int(np.argmin(first | second))]
        return Refusal(name, f"{who} ran neither order of the two conditions.", cells.excluded)
    if min(first.sum(), second.sum()) < 2:
        reason = (
            f"{first.sum()} participants began with {forward[0]} and {second.sum()} with "
            f"{forward[1]}; each order needs at least two."
        )
        return Refusal(name, reason, cells.excluded)
    effect = cells.means[:, 1] - cells.means[:, 0]
    period = np.where(first, effect, -effect)  # second period minus first
    total = cells.means.sum(axis=1)
    # Half the sum of the groups' mean effects is the condition, half the difference the period.
    return Crossover(
        condition=_two_groups(
            cells, effect[first], -effect[second], "Condition, adjusted for period", 0.5
        ),
        period=_two_groups(
            cells, period[first], -period[second], "Period, adjusted for condition", 0.5
        ),
        carry_over=_two_groups(cells, total[second], total[first], "Carry-over between orders", 1),
    )


def _two_groups(cells: Cells, one: Floats, other: Floats, name: str, factor: float) -> Outcome:
    """Test factor * (mean of one - mean of other) with the pooled variance."""
    scale = float(np.abs(cells.means).max())
    if constant(one, scale) and constant(other, scale):
        return Refusal(name, "Participants of one order do not differ at all.", cells.excluded)
    n, m = len(one), len(other)
    df = n + m - 2
    pooled = ((n - 1) * float(np.var(one, ddof=1)) + (m - 1) * float(np.var(other, ddof=1))) / df
    estimate = factor * (float(np.mean(one)) - float(np.mean(other)))
    error = factor * math.sqrt(pooled * (1 / n + 1 / m))
    t = estimate / error
    reach = float(stats.t.ppf(0.975, df)) * error
    return EffectResult(
        name=name,
        formula="mean ~ condition + period + order, error: participant within order",
        role="sensitivity",
        statistic_name="t",
        statistic=t,
        df1=None,
        df2=df,
        p=2 * float(stats.t.sf(abs(t), df)),
        estimate=estimate,
        interval=Interval(estimate - reach, estimate + reach),
        effects=(),
        rows=2 * cells.n,
        participants=cells.participants,
        excluded=cells.excluded,
        standard_error=error,
        note="Little power: it compares different people." if factor == 1 else "",
    )
