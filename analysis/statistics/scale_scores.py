"""Scores of an instrument's scale: conditions compared, and how reliable the scale is."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.contrasts import paired_contrasts
from analysis.statistics.holm import holm_of
from analysis.statistics.likert import rank_test
from analysis.statistics.reliability import Reliability, cronbach_alpha
from analysis.statistics.result import Outcome, Refusal
from analysis.statistics.rm_anova import rm_anova

Floats = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class AskedScale:
    """A scale on one occasion.

    Attributes:
        instrument: name of the instrument.
        title: what people read above it.
        version: of its wording and scoring.
        scale: name of the scale.
        occasion: "before_reveal", "after_reveal", "at_start" or "at_end".
        lowest, highest: scores possible.
        items: ids of the items that enter.
    """

    instrument: str
    title: str
    version: int
    scale: str
    occasion: str
    lowest: float
    highest: float
    items: tuple[str, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class ScaleRow:
    """What is known of one scale on one occasion.

    Attributes:
        asked: which it is.
        cells: scores of those with one under each condition.
        f_test: of the conditions: the paired t squared, or Greenhouse and Geisser's F.
        holm_f_p: its p adjusted over the family of all rows; None where refused.
        rank_test: the exact signed-rank test of two conditions; Friedman's of more.
        holm_p: its p adjusted likewise.
        contrasts: each pair of three or more conditions, Holm-adjusted among themselves.
        reliability: Cronbach's alpha under each condition, in the order of the levels; of one
            without a name where it was not asked under conditions.
    """

    asked: AskedScale
    cells: Cells
    f_test: Outcome
    holm_f_p: float | None
    rank_test: Outcome
    holm_p: float | None
    contrasts: tuple[Outcome, ...]
    reliability: tuple[tuple[str, Reliability | Refusal], ...]

    @property
    def compared(self) -> bool:
        """Whether it was asked under conditions, so that these can be compared."""
        return self.cells.levels != ("",)


def scale_rows(
    asked: Sequence[AskedScale],
    scores: pd.DataFrame,
    answers: Mapping[tuple[str, str, str, str], Floats],
    levels: Sequence[str],
) -> list[ScaleRow]:
    """Compare conditions on each scale, Holm-adjusted over all, and compute reliabilities.

    Args:
        asked: the scales on their occasions, in the order wanted.
        scores: columns "participant", "condition", "questionnaire", "scale", "occasion", "score".
        answers: answers to the items with reversed ones turned round, shape (participants,
            items), by instrument, scale, occasion and condition.
        levels: conditions, the reference first.
    """
    rows = [_row(each, scores, answers, levels) for each in asked]
    families = zip(
        rows,
        holm_of([row.f_test for row in rows]),
        holm_of([row.rank_test for row in rows]),
        strict=True,
    )
    return [dataclasses.replace(row, holm_f_p=f_p, holm_p=p) for row, f_p, p in families]


def _row(
    asked: AskedScale,
    scores: pd.DataFrame,
    answers: Mapping[tuple[str, str, str, str], Floats],
    levels: Sequence[str],
) -> ScaleRow:
    own = scores[
        (scores["questionnaire"] == asked.instrument)
        & (scores["scale"] == asked.scale)
        & (scores["occasion"] == asked.occasion)
    ]
    under = bool((own["condition"] != "").any())
    cells = cell_means(own, "score", levels if under else ("",), what="scores")
    name = f"{asked.scale}, {asked.occasion.replace('_', ' ')}"
    outside = Refusal(name, "It was asked once, not under each condition.", cells.excluded)
    none = np.zeros((0, len(asked.items)))
    reliability = []
    for level in cells.levels:
        key = (asked.instrument, asked.scale, asked.occasion, level)
        matrix = answers.get(key, none)
        reliability.append((level, cronbach_alpha(matrix, asked.items, name)))
    return ScaleRow(
        asked=asked,
        cells=cells,
        f_test=rm_anova(cells, name, "sensitivity") if under else outside,
        holm_f_p=None,
        rank_test=rank_test(cells, name) if under else outside,
        holm_p=None,
        contrasts=paired_contrasts(cells) if len(cells.levels) > 2 and cells.n else (),
        reliability=tuple(reliability),
    )
