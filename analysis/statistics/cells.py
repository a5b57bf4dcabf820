"""Participant-by-condition means: the rows that a within-subjects test rests on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.statistics.result import Excluded


@dataclasses.dataclass(frozen=True, slots=True)
class Cells:
    """One mean for each participant and condition.

    Attributes:
        participants: who has every cell, sorted.
        levels: conditions, the reference first.
        means: averages, shape (participants, levels).
        counts: how many rows each mean rests on, same shape.
        excluded: who lacks a cell, and which.
    """

    participants: tuple[str, ...]
    levels: tuple[str, ...]
    means: npt.NDArray[np.float64]
    counts: npt.NDArray[np.int64]
    excluded: tuple[Excluded, ...] = ()

    @property
    def n(self) -> int:
        """Number of participants."""
        return len(self.participants)

    def column(self, level: str) -> npt.NDArray[np.float64]:
        """Return the means of one condition, shape (n,)."""
        return self.means[:, self.levels.index(level)]

    def only(self, places: Sequence[int]) -> Cells:
        """Return some participants with every condition: those at these places."""
        return dataclasses.replace(
            self,
            participants=tuple(self.participants[place] for place in places),
            means=self.means[list(places)],
            counts=self.counts[list(places)],
        )

    def keep(self, levels: Sequence[str]) -> Cells:
        """Return the same participants with these conditions only."""
        places = [self.levels.index(level) for level in levels]
        return dataclasses.replace(
            self,
            levels=tuple(levels),
            means=self.means[:, places],
            counts=self.counts[:, places],
        )


def cell_means(frame: pd.DataFrame, value: str, levels: Sequence[str], what: str = "rows") -> Cells:
    """Average the rows of each participant under each condition.

    Args:
        frame: columns "participant", "condition" and the value's.
        value: the column to average.
        levels: conditions, the reference first.
        what: what a row is, for the reasons: "trials", "answers".

    The order of the rows does not matter, to the last bit: each cell is sorted first.
    """
    grouped: dict[tuple[str, str], list[float]] = {}
    rows = zip(frame["participant"], frame["condition"], frame[value], strict=True)
    for participant, condition, number in rows:
        grouped.setdefault((str(participant), str(condition)), []).append(float(number))
    kept: list[str] = []
    excluded: list[Excluded] = []
    for participant in sorted({key[0] for key in grouped}):
        missing = [level for level in levels if (participant, level) not in grouped]
        if missing:
            names = " and ".join(missing)
            excluded.append(Excluded(participant, f"no {what} under {names}"))
        else:
            kept.append(participant)
    values = [[float(np.mean(sorted(grouped[p, c]))) for c in levels] for p in kept]
    counts = [[len(grouped[p, c]) for c in levels] for p in kept]
    shape = (len(kept), len(levels))
    return Cells(
        participants=tuple(kept),
        levels=tuple(levels),
        means=np.array(values, dtype=np.float64).reshape(shape),
        counts=np.array(counts, dtype=np.int64).reshape(shape),
        excluded=tuple(excluded),
    )
