"""What the commands share: opening recordings and writing tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from rich.console import Console

from analysis.data_label import DataLabel
from analysis.files import claim_folder, write_json, write_pieces
from analysis.formatting import counted
from analysis.recordings import StudyRecordings, load_recordings
from analysis.tables.columns import DATA_COLUMN, Table, csv_pieces
from analysis.tables.study_tables import StudyTables
from study.recording.parts import SessionRecording


def open_recordings(paths: list[Path], console: Console, *, pool: bool) -> StudyRecordings:
    """Open the recordings and say how many there are, and which are not analysed.

    Raises:
        StudyError: nothing can be used.
    """
    with console.status("Reading recordings"):
        study = load_recordings(paths, pool=pool)
    console.print(f"Read {counted(len(study.sessions), 'session')}.", highlight=False)
    for session in study.sessions:
        for problem in session.recording.problems:
            console.print(f"Damaged: {session.file}: {problem}", markup=False, highlight=False)
        if isinstance(session.recording, SessionRecording):
            for remark in session.recording.remarks:
                console.print(f"{session.file}: {remark}", markup=False, highlight=False)
        if not session.complete:
            console.print(f"Not complete: {session.file}", markup=False, highlight=False)
    for item in study.set_aside:
        console.print(str(item), markup=False, highlight=False)
    if len(study.protocol_hashes) > 1:
        count = len(study.protocol_hashes)
        console.print(
            f"[bold yellow]WARNING: {count} different protocols are pooled, as asked. The first "
            "session's protocol stands for all.[/]"
        )
    return study


def write_tables(tables: StudyTables, label: DataLabel, folder: Path, *, long: bool = False) -> int:
    """Write every table as CSV, and what their columns mean as ``columns.json``.

    Returns:
        The number of tables written.
    """
    claim_folder(folder, "columns.json", "set of tables", ["*.csv"])
    meaning: dict[str, object] = {}
    count = 0
    for name in tables.names(long=long):
        pieces = _noted(tables.pieces(name), meaning)
        write_pieces(folder / f"{name}.csv", csv_pieces(pieces, label.line))
        count += 1
    content = {"data": label.line, "parameters": dict(label.parameters), "tables": meaning}
    write_json(folder / "columns.json", content)
    return count


def _noted(parts: Iterable[Table], meaning: dict[str, object]) -> Iterator[Table]:
    """Pass tables on; note what a row and the columns of each name mean."""
    for part in parts:
        meaning[part.name] = {
            "row": part.text,
            "columns": {
                column.name: {"type": column.dtype, "unit": column.unit, "meaning": column.text}
                for column in (*part.columns, DATA_COLUMN)
            },
        }
        yield part
