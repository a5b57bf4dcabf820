"""Participant-by-condition means: the rows that a within-subjects test rests on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.statistics.result import Excluded
from study.errors import StudyError


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


def cell_means(
    frame: pd.DataFrame,
    value: str,
    levels: Sequence[object],
    what: str = "rows",
    *,
    participant: str = "participant",
    condition: str = "condition",
) -> Cells:
    """Average the rows of each participant under each condition.

    Args:
        frame: columns of participants, of conditions and the value's.
        value: the column to average; numbers.
        levels: conditions, the reference first.
        what: what a row is, for the reasons: "trials", "answers".
        participant: the column of participants.
        condition: the column of conditions.

    The order of the rows does not matter, to the last bit: each cell is sorted first.

    Raises:
        StudyError: a column is missing or holds no numbers, or conditions are named twice.
    """
    levels = _named(levels)
    _refuse_columns(frame, value, (participant, condition, value))
    grouped: dict[tuple[str, str], list[float]] = {}
    rows = zip(as_text(frame[participant]), as_text(frame[condition]), frame[value], strict=True)
    for person, name, number in rows:
        grouped.setdefault((person, name), []).append(float(number))
    kept: list[str] = []
    excluded: list[Excluded] = []
    for person in sorted({key[0] for key in grouped}):
        missing = [level for level in levels if (person, level) not in grouped]
        if missing:
            names = " and ".join(missing)
            excluded.append(Excluded(person, f"no {what} under {names}"))
        else:
            kept.append(person)
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


def as_text(column: pd.Series) -> pd.Series:
    """Return a column as text; whole numbers without a decimal point, however they are stored."""
    if pd.api.types.is_float_dtype(column.dtype):
        values = column.to_numpy(dtype=np.float64)
        if np.all(np.isfinite(values)) and np.all(values == np.rint(values)):
            return column.astype("int64").astype(str)
    return column.astype(str)


def _named(levels: Sequence[object]) -> tuple[str, ...]:
    if isinstance(levels, str):
        raise StudyError(
            f"the conditions are given as one text, {levels!r}", "Give a list, the reference first."
        )
    names = tuple(str(level) for level in levels)
    if len(set(names)) < len(names):
        raise StudyError(f"a condition is named twice: {', '.join(names)}", "Name each once.")
    return names


def _refuse_columns(frame: pd.DataFrame, value: str, columns: Sequence[str]) -> None:
    absent = [name for name in columns if list(frame.columns).count(name) != 1]
    if absent:
        raise StudyError(
            f"the rows need one column {absent[0]!r}; they have "
            f"{', '.join(map(str, frame.columns)) or 'none'}",
            "Name the columns with value=, participant= and condition=.",
        )
    kind = frame[value].dtype
    if not (pd.api.types.is_numeric_dtype(kind) or pd.api.types.is_bool_dtype(kind)):
        if all(isinstance(number, int | float) for number in frame[value]):
            return
        raise StudyError(
            f"the column {value} does not hold numbers ({kind})", "Convert it, or name another."
        )
