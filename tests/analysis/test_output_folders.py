"""Folders for outputs: nothing of others is overwritten, nothing of an earlier output stays."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.commands.writing import write_tables
from analysis.data_label import data_label
from analysis.export import psych_ds
from analysis.recordings import StudyRecordings
from analysis.results import StudyResults
from analysis.tables.study_tables import StudyTables
from study.errors import StudyError


def test_a_folder_of_other_files_is_refused_and_left(
    study: StudyRecordings, results: StudyResults, tmp_path: Path
) -> None:
    """A README of one's own is not replaced by that of an export."""
    (tmp_path / "README.md").write_text("mine")
    with pytest.raises(StudyError, match=r"holds other files \(README.md\) and no earlier export"):
        psych_ds.export(results, tmp_path, long=False, parquet=False)
    with pytest.raises(StudyError, match="no earlier set of tables"):
        write_tables(StudyTables(study), data_label(study), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["README.md"]
    assert (tmp_path / "README.md").read_text() == "mine"


def test_tables_of_an_earlier_study_do_not_stay(study: StudyRecordings, tmp_path: Path) -> None:
    """Long tables of another call are gone: they would be read as this one's."""
    tables, label = StudyTables(study), data_label(study)
    write_tables(tables, label, tmp_path, long=True)
    assert (tmp_path / "timesteps.csv").exists()
    write_tables(tables, label, tmp_path)
    assert not (tmp_path / "timesteps.csv").exists()
    assert (tmp_path / "trials.csv").exists()


def test_an_export_replaces_an_earlier_one(results: StudyResults, tmp_path: Path) -> None:
    psych_ds.export(results, tmp_path, long=True, parquet=True)
    assert (tmp_path / "data" / "table-timesteps_data.csv").exists()
    written = psych_ds.export(results, tmp_path, long=False, parquet=False)
    there = sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*") if p.is_file())
    assert there == list(written.files)
