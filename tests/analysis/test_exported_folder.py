"""The export: a folder that others can use, with counts that agree with the recordings."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
from pyarrow import parquet

from analysis.export import psych_ds
from analysis.export.reconcile import Count, reconcile
from analysis.recordings import load_recordings
from analysis.results import StudyResults, compute_results
from analysis.tables.study_tables import StudyTables
from study.errors import StudyError

ARROW_TYPES = {
    "text": ("string", "large_string"),
    "label": ("string", "large_string"),
    "integer": ("int64",),
    "number": ("double",),
    "boolean": ("bool",),
}


@pytest.fixture(scope="module")
def exported(results: StudyResults, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The synthetic study, exported with its long tables."""
    folder: Path = tmp_path_factory.mktemp("export")
    psych_ds.export(results, folder, long=True, parquet=False)
    return folder


def test_every_column_is_described(exported: Path) -> None:
    """Each column of each file is in the description and in the codebook."""
    content = json.loads((exported / "dataset_description.json").read_text(encoding="utf-8"))
    assert content["@type"] == "Dataset"
    known = {entry["name"] for entry in content["variableMeasured"]}
    book = pd.read_csv(exported / "codebook.csv", keep_default_na=False)
    files = sorted((exported / "data").glob("*_data.csv"))
    assert len(files) == 20
    for path in [*files, exported / "jasp_jamovi" / "wide.csv"]:
        columns = set(pd.read_csv(path, nrows=1).columns)
        assert columns <= known
        assert columns <= set(book["column"])


def test_files_are_private_to_their_owner(exported: Path) -> None:
    """Files and folders tell of participants: nobody else on the machine may read them."""
    for path in exported.rglob("*"):
        assert path.stat().st_mode & 0o077 == 0, path


def test_counts_agree_with_the_recordings(exported: Path, results: StudyResults) -> None:
    """Rows in the files are the records behind them, and a lost row would be noticed."""
    content = json.loads((exported / "dataset_description.json").read_text(encoding="utf-8"))
    assert {entry["table"] for entry in content["reconciled"]} >= {"timesteps", "robots", "trials"}
    rows = {}
    for entry in content["reconciled"]:
        path = exported / "data" / f"table-{entry['table'].replace('_', '')}_data.csv"
        rows[entry["table"]] = len(pd.read_csv(path, keep_default_na=False, low_memory=False))
        assert rows[entry["table"]] == entry["rows"] == entry["records"]
    rows["switches"] -= 1
    wrong = [count for count in reconcile(results.study, rows) if not count.agrees]
    assert wrong == [Count("switches", rows["switches"], rows["switches"] + 1)]


def test_wide_has_a_row_a_participant(exported: Path, results: StudyResults) -> None:
    """Means under each condition stand side by side and are those of the primary test."""
    wide = pd.read_csv(exported / "jasp_jamovi" / "wide.csv", keep_default_na=False)
    assert len(wide) == len(results.study.sessions)
    included = wide[wide["included"]]
    assert list(included["participant"]) == list(results.cells.participants)
    for level in results.facts.levels:
        means = included[f"team_reward_{level}"].astype(float).to_numpy()
        assert means == pytest.approx(results.cells.column(level))


def test_formulas_are_neutralised_in_every_file(hostile_folder: Path, tmp_path: Path) -> None:
    """No cell of any file begins with what a spreadsheet would run."""
    study = load_recordings([hostile_folder])
    results = compute_results(study, StudyTables(study))
    psych_ds.export(results, tmp_path, long=False, parquet=False)
    for path in tmp_path.rglob("*.csv"):
        frame = pd.read_csv(path, keep_default_na=False, dtype=str)
        for name in frame.columns:
            assert not frame[name].str.startswith(("=", "@", "\t", "\r")).any(), (path, name)


def test_parquet_holds_the_same_tables_with_their_types(
    exported: Path, results: StudyResults, tmp_path: Path
) -> None:
    """Another reader finds each table's columns and rows; numbers are numbers there."""
    psych_ds.export(results, tmp_path, long=True, parquet=True)
    files = sorted((tmp_path / "parquet").iterdir())
    assert [path.stem for path in files] == sorted(results.tables.names(long=True))
    for path in files:
        name = f"table-{path.stem.replace('_', '')}_data.csv"
        declared = next(iter(results.tables.pieces(path.stem))).columns
        wanted = pd.read_csv(exported / "data" / name, low_memory=False)
        table = parquet.read_table(path)
        assert table.column_names == list(wanted.columns)
        assert table.num_rows == len(wanted)
        for column in declared:
            found = table.column(column.name)
            assert str(found.type) in ARROW_TYPES[column.dtype], (path.stem, column)
            if column.dtype in ("integer", "number"):
                values = found.to_pandas().astype(float)
                assert values.to_list() == pytest.approx(
                    wanted[column.name].astype(float).to_list(), nan_ok=True
                )


def test_parquet_without_pyarrow_says_what_to_do(
    results: StudyResults, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where pyarrow is missing the message names it."""
    monkeypatch.setitem(__import__("sys").modules, "pyarrow.parquet", None)
    with pytest.raises(StudyError, match="pyarrow"):
        psych_ds.export(results, tmp_path, long=False, parquet=True)
