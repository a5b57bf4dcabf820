"""Columns common to the tables that have a row for each timestep."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.recordings import Session, StudyRecordings, timestep_blocks
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys

Block = Mapping[str, npt.NDArray[Any]]
Columns = dict[str, Any]


def key_columns(session: Session, trial_ids: npt.NDArray[Any]) -> Columns:
    """Return the columns that place each row, for rows with these trial ids."""
    distinct, places = np.unique(trial_ids.astype(np.int64), return_inverse=True)
    keys = [trial_keys(session, int(trial_id)) for trial_id in distinct]
    columns: Columns = {}
    for column in (*SESSION_COLUMNS, *TRIAL_COLUMNS):
        values = [key[column.name] for key in keys]
        if column.dtype == "label":
            columns[column.name] = _categorical([str(value) for value in values], places)
        else:
            columns[column.name] = np.array(values, dtype=np.int64)[places]
    return columns


def names_of(codes: npt.NDArray[Any], kind: type[IntEnum] | Sequence[str]) -> pd.Categorical:
    """Return codes as names: of an enumeration in lower case, or by place in a sequence."""
    if isinstance(kind, type):
        known = {int(member): member.name.lower() for member in kind}
    else:
        known = dict(enumerate(kind))
    distinct, places = np.unique(codes.astype(np.int64), return_inverse=True)
    labels = [known.get(int(code), str(code)) for code in distinct]
    return _categorical(labels, places)


def build_from_blocks(
    study: StudyRecordings,
    name: str,
    text: str,
    columns: Sequence[Column],
    make: Callable[[Session, Block], Columns],
) -> Table:
    """Build a table by turning each block of timesteps into columns.

    Args:
        study: the recordings.
        name: the table's name.
        text: what a row is.
        columns: the declared columns.
        make: returns a block's columns, each of one length.
    """
    frames = [
        pd.DataFrame(make(session, block))
        for session in study.sessions
        for block in timestep_blocks(session)
    ]
    data: Columns = {}
    for column in columns:
        parts = [frame[column.name] for frame in frames]
        if column.dtype in ("label", "text"):
            data[column.name] = _joined(parts)
        else:
            data[column.name] = np.concatenate([part.to_numpy() for part in parts]) if parts else []
    return Table(name, text, columns, data)


def _categorical(labels: list[str], places: npt.NDArray[np.intp]) -> pd.Categorical:
    categories = sorted(set(labels))
    codes = np.array([categories.index(label) for label in labels], dtype=np.int64)
    made: pd.Categorical = pd.Categorical.from_codes(
        codes[places.reshape(-1)], categories=pd.Index(categories, dtype="str")
    )
    return made


def _joined(parts: list[pd.Series[Any]]) -> pd.Categorical:
    if not parts:
        return pd.Categorical([])
    return pd.api.types.union_categoricals(
        [part.astype("category") for part in parts], sort_categories=True
    )
