"""Ratings: the paper's F, the exact Wilcoxon test and a cumulative-link mixed model."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.cumulative_link import CumulativeLink, cumulative_link
from analysis.statistics.friedman import friedman
from analysis.statistics.holm import holm, holm_of
from analysis.statistics.pairs import SMALLEST_N
from analysis.statistics.result import EffectResult, Outcome, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.wilcoxon import signed_rank


@dataclasses.dataclass(frozen=True, slots=True)
class LikertRow:
    """One item on one occasion.

    Attributes:
        item: its id.
        occasion: "before_reveal" or "after_reveal".
        cells: one answer for each participant and condition.
        f_test: F(1, n - 1) as in the paper.
        rank_test: the exact signed-rank test of two conditions; Friedman's of more.
        holm_p: its p, adjusted over the family of all rows; None where refused.
        ordinal: the cumulative-link mixed model; its test's p_adjusted is Holm's over all rows.
        holm_f_p: the F test's p, adjusted over all rows; None where refused.
        pairs: signed-rank tests of each pair of three or more conditions, Holm-adjusted over these.
    """

    item: str
    occasion: str
    cells: Cells
    f_test: Outcome
    rank_test: Outcome
    holm_p: float | None
    ordinal: CumulativeLink | Refusal | None = None
    holm_f_p: float | None = None
    pairs: tuple[Outcome, ...] = ()

    @property
    def means(self) -> dict[str, float]:
        """Mean answer under each condition; empty where nobody answered under all."""
        if self.cells.n == 0:
            return {}
        columns = self.cells.means.T
        return {
            level: float(np.mean(np.sort(column)))
            for level, column in zip(self.cells.levels, columns, strict=True)
        }


def likert_rows(
    responses: pd.DataFrame,
    keys: Sequence[tuple[str, str]],
    levels: Sequence[str],
) -> list[LikertRow]:
    """Test each item on each occasion, Holm-adjusted over all of them.

    Args:
        responses: columns "participant", "condition", "item", "occasion", "answer".
        keys: (item, occasion) in the order wanted.
        levels: conditions, the reference first.
    """
    rows: list[LikertRow] = []
    for item, occasion in keys:
        asked = responses[(responses["item"] == item) & (responses["occasion"] == occasion)]
        cells = cell_means(asked, "answer", levels, what="answers")
        label = f"{item}, {occasion.replace('_', ' ')}"
        f_test = rm_anova(cells, name=label)
        row = LikertRow(item, occasion, cells, f_test, rank_test(cells, label), None)
        ordinal = cumulative_link(asked, levels, "answer", label)
        rows.append(dataclasses.replace(row, ordinal=ordinal, pairs=rank_pairs(cells)))
    return _adjusted(rows)


def _adjusted(rows: list[LikertRow]) -> list[LikertRow]:
    """Adjust each kind of test over the rows in which it was computed."""
    families = zip(
        rows,
        holm_of([row.rank_test for row in rows]),
        holm_of([row.f_test for row in rows]),
        strict=True,
    )
    rows = [dataclasses.replace(row, holm_p=p, holm_f_p=f_p) for row, p, f_p in families]
    models = [(n, r.ordinal) for n, r in enumerate(rows) if isinstance(r.ordinal, CumulativeLink)]
    p_values = [model.test.p for _, model in models]
    for (place, model), p in zip(models, holm(p_values), strict=True):
        adjusted = dataclasses.replace(
            model, tests=(dataclasses.replace(model.test, p_adjusted=p),)
        )
        rows[place] = dataclasses.replace(rows[place], ordinal=adjusted)
    return rows


def rank_pairs(cells: Cells) -> tuple[Outcome, ...]:
    """Compare each pair of three or more conditions by signed ranks, Holm-adjusted over these."""
    if len(cells.levels) < 3:
        return ()
    found = [
        rank_test(cells.keep(pair), f"{pair[1]} − {pair[0]}")
        for pair in itertools.combinations(cells.levels, 2)
    ]
    return tuple(
        dataclasses.replace(test, p_adjusted=p) if isinstance(test, EffectResult) else test
        for test, p in zip(found, holm_of(found), strict=True)
    )


def rank_test(cells: Cells, name: str) -> Outcome:
    """Test conditions by ranks, or refuse in words: two by signed ranks, more by Friedman's."""
    if len(cells.levels) > 2:
        return friedman(cells, name)
    if len(cells.levels) < 2:
        return Refusal(name, "There are no two conditions to compare.", cells.excluded)
    if cells.n < SMALLEST_N:
        reason = (
            f"The test needs at least {SMALLEST_N} participants who answered under both "
            f"conditions; {cells.n} did."
        )
        return Refusal(name, reason, cells.excluded)
    return signed_rank(cells.means[:, 1] - cells.means[:, 0], cells.participants, name)
