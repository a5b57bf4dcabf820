"""Pairwise paired t tests among three or more conditions, Holm-adjusted."""

from __future__ import annotations

import dataclasses
import itertools

from analysis.statistics.cells import Cells
from analysis.statistics.holm import holm_of
from analysis.statistics.result import EffectResult, Outcome
from analysis.statistics.rm_anova import rm_anova


def paired_contrasts(cells: Cells) -> tuple[Outcome, ...]:
    """Compare each pair of conditions on the participants' means.

    Each pair has its own error term, so that sphericity is not assumed. The family is all pairs
    that could be computed.

    Args:
        cells: participant means, the reference first.
    """
    found: list[Outcome] = []
    for a, b in itertools.combinations(cells.levels, 2):
        outcome = rm_anova(cells.keep((a, b)), f"{b} − {a}", "sensitivity")
        if isinstance(outcome, EffectResult) and outcome.estimate and outcome.standard_error:
            t = outcome.estimate / outcome.standard_error
            outcome = dataclasses.replace(outcome, statistic_name="t", statistic=t, df1=None)
        found.append(outcome)
    return tuple(
        dataclasses.replace(o, p_adjusted=p) if isinstance(o, EffectResult) else o
        for o, p in zip(found, holm_of(found), strict=True)
    )
