"""All tables of a study, each built when it is first asked for, a session at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import pandas as pd

from analysis.recordings import StudyRecordings
from analysis.tables import (
    attention,
    choices,
    deviations,
    episodes,
    fit_quality,
    fits,
    interventions,
    notes,
    responses,
    robots,
    scores,
    sessions,
    switches,
    texts,
    timesteps,
    timing,
    trials,
)
from analysis.tables.columns import Column, Table, joined
from study.errors import StudyError

BUILDERS: Final[dict[str, Callable[[StudyRecordings], Table]]] = {
    "sessions": sessions.build,
    "trials": trials.build,
    "episodes": episodes.build,
    "responses": responses.build,
    "texts": texts.build,
    "scores": scores.build,
    "fits": fits.build,
    "fit_metrics": fits.build_metrics,
    "held_out_trials": fit_quality.build_held_out,
    "calibration": fit_quality.build_calibration,
    "fit_gates": fit_quality.build_gates,
    "switches": switches.build,
    "interventions": interventions.build,
    "attention": attention.build,
    "timing": timing.build,
    "deviations": deviations.build,
    "notes": notes.build,
    "choices": choices.build,
    "timesteps": timesteps.build,
    "robots": robots.build,
}
"""Builder by name, in the order in which tables are listed."""

LONG_TABLES: Final = frozenset({"choices", "timesteps", "robots"})
"""Tables with a row for each timestep, or robot and timestep: written on request only."""


class StudyTables:
    """The tables of a study by name; a table is built once, when first asked for.

    Long tables are never held: `parts` gives them a session at a time, so that what is in
    memory does not grow with the number of sessions.
    """

    def __init__(self, study: StudyRecordings) -> None:
        self._study = study
        self._built: dict[str, Table] = {}
        self._rows: dict[str, int] = {}

    def parts(self, name: str) -> Iterator[Table]:
        """Yield a table a session at a time, each with the same columns.

        Raises:
            KeyError: there is no table of that name.
            StudyError: the sessions' tasks differ in the numbers that make up a state.
        """
        build = BUILDERS[name]
        declared: tuple[Column, ...] | None = None
        for session in self._study.sessions:
            part = build(StudyRecordings((session,), ()))
            declared = declared or part.columns
            if part.columns != declared:
                raise StudyError(
                    f"the table {name} cannot be pooled: the task of {session.file} has other "
                    "numbers in its states than that of the first session",
                    "Give the recordings of one task.",
                )
            yield part

    def __getitem__(self, name: str) -> Table:
        """Return a whole table, built at the first call.

        Raises:
            KeyError: there is no table of that name.
        """
        if name not in self._built:
            table = joined(list(self.parts(name)))
            self._rows[name] = len(table)
            if name in LONG_TABLES:
                return table
            self._built[name] = table
        return self._built[name]

    def frame(self, name: str) -> pd.DataFrame:
        """Return a table's data frame."""
        return self[name].frame

    def names(self, *, long: bool = False) -> list[str]:
        """Return the tables' names, with the long ones on request."""
        return [name for name in BUILDERS if long or name not in LONG_TABLES]

    def pieces(self, name: str) -> Iterator[Table]:
        """Yield a table in pieces that fit in memory: whole if it is short or held already."""
        if name in LONG_TABLES:
            count = 0
            for part in self.parts(name):
                count += len(part)
                yield part
            self._rows[name] = count
        else:
            yield self[name]

    def rows(self, name: str) -> int:
        """Return how many rows a table has, without keeping a long one."""
        if name not in self._rows:
            self._rows[name] = sum(len(part) for part in self.pieces(name))
        return self._rows[name]
