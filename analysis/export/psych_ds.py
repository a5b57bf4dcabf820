"""A folder that others can use without this program: Psych-DS, wide CSV, Parquet.

Psych-DS 1: data as CSV under ``data/``, named ``<keyword>-<value>_data.csv``, described by
``dataset_description.json`` at the root (https://psych-ds.github.io).
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import pandas as pd

from analysis.environment import environment
from analysis.export.reconcile import Count, reconcile
from analysis.export.wide import wide_table
from analysis.files import (
    claim_folder,
    make_folder,
    open_private,
    write_json,
    write_pieces,
    write_text,
)
from analysis.results import StudyResults
from analysis.tables.columns import DATA_COLUMN, Column, Table, csv_pieces
from study.errors import StudyError

KINDS = {
    "text": "string",
    "label": "string",
    "integer": "integer",
    "number": "number",
    "boolean": "boolean",
}


@dataclasses.dataclass(frozen=True, slots=True)
class Exported:
    """What was written.

    Attributes:
        files: relative to the folder, in order.
        counts: rows against records.
    """

    files: tuple[str, ...]
    counts: tuple[Count, ...]


def export(results: StudyResults, folder: Path, *, long: bool, parquet: bool) -> Exported:
    """Write the folder; files already there are made anew.

    Args:
        results: of the study.
        folder: where to.
        long: also the tables with a row for each timestep.
        parquet: also every table as Parquet, under ``parquet/``.

    Raises:
        StudyError: the folder cannot be written, pyarrow is missing, or counts do not agree.
    """
    claim_folder(
        folder,
        "dataset_description.json",
        "export",
        ["data/table-*_data.csv", "parquet/*.parquet", "jasp_jamovi/wide.csv", "minari"],
    )
    make_folder(folder / "data")
    if parquet:
        _require_pyarrow()
        make_folder(folder / "parquet")
    label = results.label
    files: list[str] = []
    rows: dict[str, int] = {}
    described: dict[str, tuple[str, tuple[Column, ...]]] = {}
    for name in results.tables.names(long=long):
        path = f"data/{_file_name(name)}"
        writer = _Parquet(folder / "parquet" / f"{name}.parquet") if parquet else None
        parts = _parts(results, name, rows, described, writer)
        write_pieces(folder / path, csv_pieces(parts, label.line))
        if writer is not None:
            writer.close()
            files.append(f"parquet/{name}.parquet")
        files.append(path)
    wide = wide_table(results)
    described["wide"] = (wide.text, wide.columns)
    make_folder(folder / "jasp_jamovi")
    write_text(folder / "jasp_jamovi" / "wide.csv", wide.to_csv(None, points=False))
    files.append("jasp_jamovi/wide.csv")
    counts = reconcile(results.study, rows)
    wrong = [count for count in counts if not count.agrees]
    if wrong:
        lines = [f"{c.table}: {c.rows} rows, {c.records} records" for c in wrong]
        raise StudyError(
            "the tables do not agree with the recordings: " + "; ".join(lines),
            "Please report this with the recordings' SHA-256; do not use the export.",
        )
    content = _description(results, described, counts)
    write_json(folder / "dataset_description.json", content)
    write_text(folder / "codebook.csv", _codebook(described).to_csv(label.line))
    write_text(folder / "README.md", _readme(results, rows))
    files += ["dataset_description.json", "codebook.csv", "README.md"]
    return Exported(tuple(sorted(files)), tuple(counts))


def _parts(
    results: StudyResults,
    name: str,
    rows: dict[str, int],
    described: dict[str, tuple[str, tuple[Column, ...]]],
    writer: _Parquet | None,
) -> Iterator[Table]:
    """Yield a table's parts; note what they are and how many rows, and write them as Parquet."""
    rows[name] = 0
    for part in results.tables.pieces(name):
        described[name] = (part.text, (*part.columns, DATA_COLUMN))
        rows[name] += len(part)
        if writer is not None:
            writer.add(part.frame.assign(**{DATA_COLUMN.name: results.label.line}))
        yield part


def _file_name(table: str) -> str:
    """Return a table's file in Psych-DS: keyword, value without a mark, suffix."""
    return f"table-{table.replace('_', '')}_data.csv"


class _Parquet:
    """Writes a table to Parquet, part by part: the same types as declared, text as it is."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._part = path.with_name(f".{path.name}.part")
        self._stream: BinaryIO | None = None
        self._writer: Any = None

    def add(self, frame: pd.DataFrame) -> None:
        """Append rows."""
        import pyarrow as pa  # noqa: PLC0415 - optional
        import pyarrow.parquet as pq  # noqa: PLC0415 - optional

        # Categories differ from session to session; plain text is the same everywhere.
        plain = {
            name: frame[name].astype("str")
            for name in frame.columns
            if str(frame[name].dtype) == "category"
        }
        table = pa.Table.from_pandas(frame.assign(**plain), preserve_index=False)
        table = table.replace_schema_metadata(None)
        if self._writer is None:
            try:
                self._stream = os.fdopen(open_private(self._part), "wb")
            except OSError as error:
                raise StudyError(f"{self._path} cannot be written: {error.strerror}") from error
            self._writer = pq.ParquetWriter(self._stream, table.schema)
        try:
            self._writer.write_table(table.cast(self._writer.schema))
        except OSError as error:
            raise StudyError(f"{self._path} cannot be written: {error}") from error

    def close(self) -> None:
        """Finish the file, which appears under its name only now."""
        if self._writer is None or self._stream is None:
            return
        try:
            self._writer.close()
            self._stream.close()
            self._part.replace(self._path)
        except OSError as error:
            raise StudyError(f"{self._path} cannot be written: {error}") from error


def _require_pyarrow() -> None:
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415 - optional
    except ImportError as error:
        raise StudyError(
            "Parquet needs the package pyarrow, which is not installed",
            "Install it with `pip install 'scaled-autonomy[parquet]'`, or leave out --parquet.",
        ) from error


def _description(
    results: StudyResults,
    described: dict[str, tuple[str, tuple[Column, ...]]],
    counts: list[Count],
) -> dict[str, object]:
    variables: dict[str, dict[str, object]] = {}
    for table, (_, columns) in described.items():
        for column in columns:
            entry = variables.setdefault(
                column.name,
                {
                    "@type": "PropertyValue",
                    "name": column.name,
                    "description": column.text,
                    "unitText": column.unit,
                    "valueReference": KINDS[column.dtype],
                    "tables": [],
                },
            )
            tables = entry["tables"]
            assert isinstance(tables, list)  # noqa: S101 - made so above
            tables.append(table)
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "schemaVersion": "Psych-DS 1.4.0",
        "name": results.facts.title,
        "description": f"{results.label.line}. Tables computed from recordings of sessions.",
        "variableMeasured": list(variables.values()),
        "protocolSHA256": list(results.study.protocol_hashes),
        "recordings": [
            {"file": session.file, "sha256": session.recording.sha256}
            for session in results.study.sessions
        ],
        "madeWith": environment(),
        "reconciled": [{"table": c.table, "rows": c.rows, "records": c.records} for c in counts],
    }


def _codebook(described: dict[str, tuple[str, tuple[Column, ...]]]) -> Table:
    columns = (
        Column("table", "text", "name of the table"),
        Column("column", "text", "name of the column"),
        Column("type", "text", "string, integer, number or boolean"),
        Column("unit", "text", "unit, or empty"),
        Column("meaning", "text", "what it means"),
    )
    rows = [
        {
            "table": table,
            "column": column.name,
            "type": KINDS[column.dtype],
            "unit": column.unit,
            "meaning": column.text,
        }
        for table, (_, declared) in described.items()
        for column in declared
    ]
    return Table.from_rows("codebook", "One row a column.", columns, rows)


def _readme(results: StudyResults, rows: dict[str, int]) -> str:
    listed = "\n".join(f"- `{_file_name(name)}`: {count} rows" for name, count in rows.items())
    title = " ".join(results.facts.title.split())
    return (
        f"# {title}\n\n{results.label.line}.\n\n"
        "Psych-DS: `dataset_description.json` says what each column means; `codebook.csv` says\n"
        "the same as a table. `jasp_jamovi/wide.csv` has a row for each participant.\n\n"
        "Text that a spreadsheet would run as a formula begins with an apostrophe in every CSV\n"
        "file; Parquet files hold it as it was given.\n\n"
        f"{listed}\n"
    )
