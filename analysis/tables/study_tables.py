"""All tables of a study, each built when it is first asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import pandas as pd

from analysis.recordings import StudyRecordings
from analysis.tables import (
    choices,
    deviations,
    episodes,
    fits,
    interventions,
    responses,
    robots,
    sessions,
    switches,
    timesteps,
    timing,
    trials,
)
from analysis.tables.columns import Table

BUILDERS: Final[dict[str, Callable[[StudyRecordings], Table]]] = {
    "sessions": sessions.build,
    "trials": trials.build,
    "episodes": episodes.build,
    "responses": responses.build,
    "fits": fits.build,
    "fit_metrics": fits.build_metrics,
    "switches": switches.build,
    "interventions": interventions.build,
    "timing": timing.build,
    "deviations": deviations.build,
    "choices": choices.build,
    "timesteps": timesteps.build,
    "robots": robots.build,
}
"""Builder by name, in the order in which tables are listed."""

LONG_TABLES: Final = frozenset({"choices", "timesteps", "robots"})
"""Tables with a row for each timestep, or robot and timestep: written on request only."""


class StudyTables:
    """The tables of a study by name; a table is built once, when first asked for."""

    def __init__(self, study: StudyRecordings) -> None:
        self._study = study
        self._built: dict[str, Table] = {}
        self._rows: dict[str, int] = {}

    def __getitem__(self, name: str) -> Table:
        """Return a table.

        Raises:
            KeyError: there is no such table.
        """
        if name not in self._built:
            self._built[name] = BUILDERS[name](self._study)
            self._rows[name] = len(self._built[name])
        return self._built[name]

    def frame(self, name: str) -> pd.DataFrame:
        """Return a table's data frame."""
        return self[name].frame

    def names(self, *, long: bool = False) -> list[str]:
        """Return the tables' names, with the long ones on request."""
        return [name for name in BUILDERS if long or name not in LONG_TABLES]

    def each(self, *, long: bool = False) -> Iterator[Table]:
        """Yield the tables one by one; long ones are not kept."""
        for name in self.names(long=long):
            table = BUILDERS[name](self._study) if name in LONG_TABLES else self[name]
            self._rows[name] = len(table)
            yield table

    def rows(self, name: str) -> int:
        """Return how many rows a table has, without keeping it."""
        if name not in self._rows:
            self._rows[name] = len(BUILDERS[name](self._study))
        return self._rows[name]
