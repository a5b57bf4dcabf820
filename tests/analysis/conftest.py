"""Synthetic studies that several test files read."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.recordings import StudyRecordings, load_recordings
from analysis.results import StudyResults, compute_results
from analysis.tables.study_tables import StudyTables
from synthetic_study import HOSTILE, Plan, study_plans, tear, write_session


@pytest.fixture(scope="session")
def study_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six whole sessions, an incomplete one, a torn one and a file that is no recording."""
    folder: Path = tmp_path_factory.mktemp("study")
    for plan in study_plans(6, trials=3, timesteps=12, planned=8):
        write_session(folder, plan)
    short = {"trials": 3, "timesteps": 12, "planned": 8}
    # Three of phase one, three of phase two, one whole block and one trial of the next.
    write_session(folder, Plan("P07", 6, stop_after=10, **short))  # type: ignore[arg-type]
    torn = Plan("P08", 7, **{**short, "timesteps": 40})  # type: ignore[arg-type]
    tear(write_session(folder, torn), 0.7)
    (folder / "notes.mcap").write_bytes(b"no recording at all")
    return folder


@pytest.fixture(scope="session")
def study(study_folder: Path) -> StudyRecordings:
    """The recordings of the synthetic study."""
    return load_recordings([study_folder])


@pytest.fixture(scope="session")
def tables(study: StudyRecordings) -> StudyTables:
    """Its tables."""
    return StudyTables(study)


@pytest.fixture(scope="session")
def results(study: StudyRecordings, tables: StudyTables) -> StudyResults:
    """Its results."""
    return compute_results(study, tables)


@pytest.fixture(scope="session")
def hostile_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sessions of persons whose id and title try to be markup or a formula."""
    folder: Path = tmp_path_factory.mktemp("hostile")
    for index, participant in enumerate([HOSTILE, "=HYPERLINK(1)"]):
        plan = Plan(
            participant,
            index,
            trials=1,
            timesteps=4,
            operator_kind="person",
            title="A & B </style><b onclick=x>",
            planned=2,
        )
        write_session(folder, plan)
    return folder
