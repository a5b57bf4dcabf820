"""Three or more conditions in balanced Latin squares: condition, period and carry-over.

Williams' squares (1949, Australian Journal of Scientific Research A 2, 149-168) let each
condition follow each other equally often, so that first-order carry-over can be told from the
condition. The model is that of Jones & Kenward (2014), Design and Analysis of Cross-Over Trials,
chapter 5: participants fixed, each term adjusted for the others.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from scipy import stats

from analysis.statistics.cells import Cells
from analysis.statistics.effect_sizes import partial_eta_squared
from analysis.statistics.pairs import SMALLEST_N, not_finite
from analysis.statistics.result import EffectResult, Outcome, Refusal

Floats = npt.NDArray[np.float64]
FORMULA = "mean ~ participant + period + condition + condition before"


@dataclasses.dataclass(frozen=True, slots=True)
class LatinSquare:
    """The three questions of a design with orders.

    Attributes:
        condition: adjusted for period and carry-over.
        period: adjusted for condition and carry-over.
        carry_over: of the condition before; adjusted for condition and period.
        balanced: whether each condition followed each other equally often.
    """

    condition: Outcome
    period: Outcome
    carry_over: Outcome
    balanced: bool

    @property
    def outcomes(self) -> tuple[Outcome, Outcome, Outcome]:
        """All three, in the order of the tables."""
        return self.condition, self.period, self.carry_over


def follows_equally(orders: Sequence[Sequence[str]], levels: Sequence[str]) -> bool:
    """Return whether each condition follows each other one equally often, and fills each period."""
    pairs = Counter(pair for order in orders for pair in itertools.pairwise(order))
    places = Counter(pair for order in orders for pair in enumerate(order))
    follow = {pairs[a, b] for a in levels for b in levels if a != b}
    fill = {places[place, a] for place in range(len(levels)) for a in levels}
    return len(follow) == 1 and len(fill) == 1


def latin_square(cells: Cells, orders: Mapping[str, tuple[str, ...]]) -> LatinSquare | Refusal:
    """Test condition, period and carry-over on participant means.

    Args:
        cells: participant means under three or more conditions.
        orders: each participant's conditions in the order run, each condition once.
    """
    name = "Orders (Latin squares)"
    n, k = cells.means.shape
    if k < 3:
        reason = f"The design has three or more conditions; these data hold {k}."
        return Refusal(name, reason, cells.excluded)
    if n < SMALLEST_N:
        reason = f"The model needs at least {SMALLEST_N} participants; {n} have every condition."
        return Refusal(name, reason, cells.excluded)
    refusal = not_finite(cells, name)
    if refusal is not None:
        return refusal
    run = [tuple(orders.get(who, ())) for who in cells.participants]
    for who, order in zip(cells.participants, run, strict=True):
        if sorted(order) != sorted(cells.levels):
            reason = f"{who} did not run each condition once: {', '.join(order) or 'no order'}."
            return Refusal(name, reason, cells.excluded)
    parts = _design(run, cells.levels)
    y = np.array(
        [
            cells.means[place, cells.levels.index(condition)]
            for place, order in enumerate(run)
            for condition in order
        ]
    )
    whole = np.column_stack(list(parts.values()))
    df2 = len(y) - int(np.linalg.matrix_rank(whole))
    rss = _residual(whole, y)
    spread = float(np.sum((y - y.mean()) ** 2))
    if df2 < 1 or not rss > 1e-20 * max(spread, float(np.sum(y**2))):
        reason = "The means leave no scatter about the model to test against."
        return Refusal(name, reason, cells.excluded)

    def tested(term: str, label: str) -> Outcome:
        rest = np.column_stack([part for key, part in parts.items() if key != term])
        df1 = int(np.linalg.matrix_rank(whole) - np.linalg.matrix_rank(rest))
        if df1 < parts[term].shape[1]:
            reason = f"The orders run do not tell {label.lower()} from the other terms."
            return Refusal(label, reason, cells.excluded, FORMULA)
        f = max(0.0, _residual(rest, y) - rss) / df1 / (rss / df2)
        return EffectResult(
            name=label,
            formula=FORMULA,
            role="sensitivity",
            statistic_name="F",
            statistic=f,
            df1=df1,
            df2=df2,
            p=float(stats.f.sf(f, df1, df2)),
            estimate=None,
            interval=None,
            effects=(partial_eta_squared(f, df1, df2),),
            rows=len(y),
            participants=cells.participants,
            excluded=cells.excluded,
        )

    return LatinSquare(
        condition=tested("condition", "Condition, adjusted for period and carry-over"),
        period=tested("period", "Period"),
        carry_over=tested("before", "Carry-over of the condition before"),
        balanced=follows_equally(run, cells.levels),
    )


def _design(run: Sequence[tuple[str, ...]], levels: tuple[str, ...]) -> dict[str, Floats]:
    """Code each term by deviations from its mean; the first period carries nothing over."""
    n, k = len(run), len(levels)
    deviations = np.vstack([np.eye(k - 1), -np.ones(k - 1)])
    code = {level: deviations[place] for place, level in enumerate(levels)}
    condition = np.array([code[c] for order in run for c in order])
    nothing = np.zeros(k - 1)
    before = np.array([row for order in run for row in (nothing, *(code[c] for c in order[:-1]))])
    return {
        "participant": np.kron(np.eye(n), np.ones((k, 1))),
        "period": np.tile(deviations, (n, 1)),
        "condition": condition,
        "before": before,
    }


def _residual(x: Floats, y: Floats) -> float:
    fitted = x @ np.linalg.lstsq(x, y, rcond=None)[0]
    return float(np.sum((y - fitted) ** 2))
