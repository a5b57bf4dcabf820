"""Which rows of a data frame enter a model, with what is wrong about the frame said in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from analysis.statistics.cells import as_text
from analysis.statistics.mixed.design import NotEstimableError
from analysis.statistics.mixed.formula import Formula
from analysis.statistics.result import Excluded, ExcludedRows

Levels = Mapping[str, Sequence[object]]
SHOWN = 6
"""So many levels are named in a message."""


def usable_rows(
    frame: pd.DataFrame, formula: Formula, levels: Levels, participant: str
) -> tuple[pd.DataFrame, tuple[ExcludedRows, ...]]:
    """Leave out rows without values, and those of levels that are not compared; count both.

    Args:
        frame: one row an observation.
        formula: the model.
        levels: levels of each factor, the reference first.
        participant: the column that names participants.

    Returns:
        The rows with factors and groups as text, and what was left out.

    Raises:
        NotEstimableError: a missing column, a factor without two different levels, text where
            numbers are needed, a number that is not finite, or no row left.
    """
    names = tuple(dict.fromkeys((formula.response, *formula.names, participant)))
    _refuse_unknown(frame, names, levels)
    grouping = {name for random in formula.random for name in random.group} | {participant}
    for column in names:
        if column not in levels and column not in grouping:
            _refuse_text(frame, column)
    dropped = []
    for column in names:
        missing = frame[column].isna()
        if missing.any():
            dropped.append(ExcludedRows(int(missing.sum()), f"no value of {column}"))
            frame = frame[~missing]
    if frame.empty:
        raise NotEstimableError(f"No row has a value in each of {', '.join(names)}.")
    worded = [column for column in names if column in levels or column in grouping]
    frame = frame.assign(**{column: as_text(frame[column]) for column in worded})
    for column in (column for column in names if column in levels):
        known = [str(level) for level in levels[column]]
        other = ~frame[column].isin(known)
        if other.all():
            held = sorted(set(frame[column]))
            shown = ", ".join(held[:SHOWN]) + (", ..." if len(held) > SHOWN else "")
            raise NotEstimableError(
                f"No row has a level of {column} that is compared ({', '.join(known)}); the rows "
                f"hold {shown}."
            )
        if other.any():
            dropped.append(ExcludedRows(int(other.sum()), f"{column} is not one compared"))
            frame = frame[~other]
    for column in (column for column in names if column not in worded):
        if not np.isfinite(frame[column].to_numpy(dtype=np.float64)).all():
            raise NotEstimableError(f"The column {column} holds a value that is not finite.")
    return frame, tuple(dropped)


def left_out(frame: pd.DataFrame, rows: pd.DataFrame, participant: str) -> tuple[Excluded, ...]:
    """Name the participants of a frame of whom no row entered."""
    everybody = set(as_text(frame[participant].dropna()))
    gone = sorted(everybody - set(rows[participant]))
    return tuple(Excluded(who, "no row that enters") for who in gone)


def participant_column(frame: pd.DataFrame, formula: Formula) -> str:
    """Return "participant" if there is such a column, else what the first random term groups by."""
    known = "participant" in frame.columns or not formula.random
    return "participant" if known else formula.random[0].group[0]


def _refuse_unknown(frame: pd.DataFrame, names: Sequence[str], levels: Levels) -> None:
    absent = [column for column in names if column not in frame.columns]
    if absent:
        raise NotEstimableError(
            f"The rows have no column {' or '.join(absent)}; they have "
            f"{', '.join(map(str, frame.columns))}."
        )
    double = [column for column in names if list(frame.columns).count(column) > 1]
    if double:
        raise NotEstimableError(f"The rows have more than one column {double[0]}.")
    for column, known in levels.items():
        if isinstance(known, str):
            raise NotEstimableError(
                f"The levels of {column} are given as one text, {known!r}; give a list of them."
            )
        if column in names and len({str(level) for level in known}) < max(2, len(known)):
            given = ", ".join(str(level) for level in known) or "none"
            raise NotEstimableError(
                f"The factor {column} needs two or more different levels; given: {given}."
            )


def _refuse_text(frame: pd.DataFrame, column: str) -> None:
    kind = frame[column].dtype
    if not (pd.api.types.is_numeric_dtype(kind) or pd.api.types.is_bool_dtype(kind)):
        raise NotEstimableError(
            f"The column {column} does not hold numbers ({kind}). If it is a factor, name its "
            "levels, the reference first."
        )
