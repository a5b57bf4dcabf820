"""The paired test with each participant left out in turn: does one person carry the result?"""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.statistics.cells import Cells
from analysis.statistics.pairs import SMALLEST_N, differences
from analysis.statistics.result import EffectResult, Refusal
from analysis.statistics.rm_anova import rm_anova


@dataclasses.dataclass(frozen=True, slots=True)
class LeftOut:
    """The paired test without one participant.

    Attributes:
        participant: who was left out.
        result: the test of the others.
    """

    participant: str
    result: EffectResult


@dataclasses.dataclass(frozen=True, slots=True)
class LeaveOneOut:
    """All of them, in the order of the participants.

    Attributes:
        each: one for each participant.
        estimates: the smallest and the largest difference.
        p_values: the smallest and the largest p.
        most_influential: who changes the estimate most.
        same_sign: whether every estimate has the sign of the whole.
    """

    each: tuple[LeftOut, ...]
    estimates: tuple[float, float]
    p_values: tuple[float, float]
    most_influential: str
    same_sign: bool


def leave_one_out(cells: Cells, name: str = "Leaving one participant out") -> LeaveOneOut | Refusal:
    """Repeat the paired test without each participant in turn.

    Args:
        cells: participant means under two conditions; at least four participants.
        name: what the tables call it.
    """
    found = differences(cells, name)
    if isinstance(found, Refusal):
        return found
    if cells.n <= SMALLEST_N:
        reason = f"With {cells.n} participants too few are left when one is left out."
        return Refusal(name, reason, cells.excluded)
    each = []
    for place, who in enumerate(cells.participants):
        others = cells.only([other for other in range(cells.n) if other != place])
        result = rm_anova(others, f"Without {who}", "sensitivity")
        if isinstance(result, Refusal):
            reason = f"Without {who} there is no test: {result.reason}"
            return Refusal(name, reason, cells.excluded)
        each.append(LeftOut(who, result))
    whole = float(np.mean(found))
    estimates = np.array([float(left.result.estimate or 0.0) for left in each])
    p_values = [left.result.p for left in each]
    return LeaveOneOut(
        each=tuple(each),
        estimates=(float(estimates.min()), float(estimates.max())),
        p_values=(min(p_values), max(p_values)),
        most_influential=each[int(np.argmax(np.abs(estimates - whole)))].participant,
        same_sign=bool(np.all(np.sign(estimates) == np.sign(whole))),
    )
