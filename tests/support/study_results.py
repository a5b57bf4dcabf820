"""Results of made-up studies, by way of their recordings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from analysis.recordings import load_recordings
from analysis.results import StudyResults, compute_results
from analysis.tables.study_tables import StudyTables
from synthetic_study import Plan, write_session


def results_of(folder: Path, plans: Iterable[Plan]) -> StudyResults:
    """Record the sessions planned, and return the results of what a folder then holds."""
    for plan in plans:
        write_session(folder, plan)
    study = load_recordings([folder])
    return compute_results(study, StudyTables(study))
