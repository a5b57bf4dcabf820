"""An experiment's results as data frames, and what its protocol says of them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pandas as pd

from analysis.formatting import counted
from study.errors import StudyError
from study.toml_text import parse_toml
from study.trial_files import Results, read_results
from study.trial_tables import COLUMNS

GROUND_TRUTH, CORRECTED, NONE = "ground_truth", "corrected", "none"


@dataclasses.dataclass(frozen=True, slots=True)
class Experiment:
    """An experiment that was read.

    Attributes:
        results: its files.
        protocol: its TOML, as plain values.
        tables: a data frame a table, with the columns of `study.trial_files.COLUMNS`.
    """

    results: Results
    protocol: dict[str, Any]
    tables: dict[str, pd.DataFrame]

    @property
    def trials(self) -> int:
        """Trials that are there and whole."""
        return len(self.results.trials)

    @property
    def planned(self) -> int:
        """Trials that the protocol plans."""
        return int(self.protocol["experiment"]["trials"])

    @property
    def dwells(self) -> list[int]:
        """Dwells of phase three, as the protocol lists them."""
        return [int(dwell) for dwell in self.protocol["phase_three"]["dwells"]]

    @property
    def training(self) -> str:
        """Which demonstrations phase four's main policies are fitted to."""
        return str(self.protocol["phase_four"]["training"][0])

    @property
    def luce(self) -> str | None:
        """Name of the paper's scorer."""
        return self._named("luce")

    @property
    def classifier(self) -> str | None:
        """Name of the paper's baseline."""
        return self._named("classifier")

    def _named(self, member: str) -> str | None:
        return next(
            (key for key, part in self.protocol["scorers"].items() if part["name"] == member), None
        )

    def label(self, scorer: str) -> str:
        """Return what a report calls a scorer."""
        fixed = {
            GROUND_TRUTH: "Ground truth",
            NONE: "Nobody helps",
            CORRECTED: "Luce, corrected",
        }
        if scorer in fixed:
            return fixed[scorer]
        return str(self.protocol["scorers"].get(scorer, {}).get("label", scorer))

    @property
    def scorers(self) -> list[str]:
        """All scorers there are rows of, in the report's order."""
        known = [GROUND_TRUTH, *self.protocol["scorers"], NONE]
        if "correction" in self.protocol:
            at = self.protocol["correction"]["scorer"]
            known.insert(known.index(at) + 1, CORRECTED)
        there = set(self.tables["runs"]["scorer"])
        return [name for name in known if name in there]


def load_experiment(folder: Path) -> Experiment:
    """Read an experiment's results.

    Raises:
        StudyError: there are none, or fewer than two trials are whole.
    """
    results = read_results(folder)
    if len(results.trials) < 2:
        raise StudyError(
            f"{folder}: {counted(len(results.trials), 'whole trial')}; a report needs two",
            "Run the same study experiment again, with more --trials.",
        )
    tables = {
        name: pd.DataFrame(
            [row for trial in results.trials for row in trial.tables[name]], columns=list(columns)
        )
        for name, columns in COLUMNS.items()
    }
    protocol = parse_toml(results.head.protocol, f"{folder}: its protocol")
    return Experiment(results, protocol, tables)
