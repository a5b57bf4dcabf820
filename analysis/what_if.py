"""What `study whatif` found, as data frames, held against the recordings of a report."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from analysis.formatting import counted, listed
from analysis.recordings import StudyRecordings
from study.errors import StudyError
from study.whatif_files import read_head, read_table
from study.whatif_tables import COLUMNS

READ = tuple(name for name in COLUMNS if name != "choices")
"""Tables that a report rests on; that of the choices is for other programs."""


@dataclasses.dataclass(frozen=True, slots=True)
class WhatIf:
    """Tables of scorers asked about recorded choices.

    Attributes:
        settings: what was asked for.
        versions: of what computed them.
        tables: data frames by name, of the participants in the report.
        notes: in words, what could not be done, and where tables and recordings differ.
    """

    settings: Mapping[str, Any]
    versions: Mapping[str, str]
    tables: Mapping[str, pd.DataFrame]
    notes: tuple[str, ...]

    def setting(self, name: str) -> int:
        """Return a whole number that was asked for; 0 if it is not stated."""
        value = self.settings.get(name)
        return value if isinstance(value, int) else 0

    @property
    def driver(self) -> str:
        """Who drove the robots taken over, in words."""
        given = str(self.settings.get("driver", ""))[:200]
        known = {
            "trained": "the user trained on the task",
            "demonstrations": "the nearest of the participant’s own demonstrations",
        }
        return known.get(given, f"the user trained as {Path(given).name}")


def load_what_if(folder: Path, study: StudyRecordings) -> WhatIf:
    """Read the tables and keep what is of the report's recordings.

    Raises:
        StudyError: the folder cannot be used, or its tables are of none of the recordings.
    """
    head = read_head(folder)
    frames = {
        name: pd.DataFrame(read_table(folder, head, name), columns=list(COLUMNS[name]))
        for name in READ
    }
    known = {digest for session in study.sessions for _, digest in session.files}
    made_of = frames["recordings"]
    same = made_of[made_of["sha256"].isin(known)]
    if not len(same):
        raise StudyError(
            f"{folder} is of none of these recordings",
            "Make the tables anew with `study whatif` on the recordings of the report.",
        )
    sessions = set(same["session"])
    asked = {session.opened.participant for session in study.sessions}
    missing = sorted(asked - set(same["participant"]))
    strange = sorted(set(made_of["participant"]) - set(same["participant"]))
    given = head.settings.get("notes")
    notes = [str(note)[:400] for note in given] if isinstance(given, list) else []
    if missing:
        notes.append(f"No scorer was asked about the choices of {listed(missing)}.")
    if strange:
        notes.append(
            f"{counted(len(strange), 'recording')} that scorers were asked about {_is(strange)} "
            "not in this report, and left out."
        )
    kept = {
        name: frame[frame["session"].isin(sessions)] if "session" in frame else frame
        for name, frame in frames.items()
    }
    matrix = kept["matrix"]
    kept["matrix"] = matrix[matrix["scorer_of"].isin(set(same["participant"]))]
    return WhatIf(head.settings, head.versions, kept, tuple(notes))


def pooled(frame: pd.DataFrame, by: list[str], values: list[str]) -> pd.DataFrame:
    """Average rows of a table over choices: each row counts as often as it has choices.

    Args:
        frame: with "choices" and the values; a missing value makes its mean missing.
        by: columns that tell groups apart.
        values: columns to average.

    Returns:
        One row a group, sorted: the columns of ``by``, "choices" and the means. The order of the
        rows given does not matter, to the last bit.
    """
    rows = []
    for key, group in frame.groupby(by, sort=True):
        weights = group["choices"].to_numpy(dtype=np.float64)
        row = dict(zip(by, key if isinstance(key, tuple) else (key,), strict=True))
        row["choices"] = int(weights.sum())
        for value in values:
            products = np.sort(group[value].to_numpy(dtype=np.float64) * weights)
            row[value] = float(products.sum() / weights.sum())
        rows.append(row)
    return pd.DataFrame(rows, columns=[*by, "choices", *values])


def _is(words: list[str]) -> str:
    return "is" if len(words) == 1 else "are"
