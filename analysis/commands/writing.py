"""What the commands share: opening recordings and writing files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from rich.console import Console

from analysis.data_label import DataLabel
from analysis.formatting import counted
from analysis.recordings import StudyRecordings, load_recordings
from analysis.tables.columns import DATA_COLUMN, Table
from analysis.tables.study_tables import StudyTables
from study.errors import StudyError


def open_recordings(paths: list[Path], console: Console, *, mixed: bool) -> StudyRecordings:
    """Open the recordings and say how many there are, and which are set aside.

    Raises:
        StudyError: nothing can be used.
    """
    with console.status("Reading recordings"):
        study = load_recordings(paths, mixed=mixed)
    console.print(f"Read {counted(len(study.sessions), 'session')}.", highlight=False)
    for session in study.sessions:
        for problem in session.recording.problems:
            console.print(f"Damaged: {session.file}: {problem}", markup=False, highlight=False)
        if not session.complete:
            console.print(f"Not complete: {session.file}", markup=False, highlight=False)
    for item in study.set_aside:
        console.print(f"Set aside {item.file}: {item.reason}", markup=False, highlight=False)
    if len(study.protocol_hashes) > 1:
        count = len(study.protocol_hashes)
        console.print(f"[bold yellow]Pooled {count} different protocols, as asked.[/]")
    return study


def make_folder(folder: Path) -> None:
    """Make a folder for outputs, private to its owner if it is new.

    Raises:
        StudyError: it cannot be made or is a file.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise StudyError(
            f"the folder {folder} cannot be made: {error.strerror}", "Choose another with -o."
        ) from error


def write_text(path: Path, text: str) -> None:
    """Write a file in one step, so that nobody ever sees half of it.

    Raises:
        StudyError: it cannot be written.
    """
    write_pieces(path, [text])


def write_json(path: Path, content: object) -> None:
    """Write a file of JSON for people to read too.

    Raises:
        StudyError: it cannot be written.
    """
    write_text(path, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def write_pieces(path: Path, pieces: Iterable[str]) -> None:
    """Write a file piece by piece; it appears under its name when it is whole.

    Raises:
        StudyError: it cannot be written.
    """
    part = path.with_name(f".{path.name}.part")
    try:
        with os.fdopen(open_private(part), "w", encoding="utf-8", newline="\n") as stream:
            for piece in pieces:
                stream.write(piece)
        os.replace(part, path)  # noqa: PTH105 - Path.replace reads as a change of text
    except OSError as error:
        raise StudyError(f"{path} cannot be written: {error.strerror}") from error


def open_private(path: Path) -> int:
    """Open a file anew for writing, for its owner alone: it tells of participants.

    Raises:
        OSError: it cannot be made.
    """
    path.unlink(missing_ok=True)
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)


def write_tables(tables: StudyTables, label: DataLabel, folder: Path, *, long: bool = False) -> int:
    """Write every table as CSV, and what their columns mean as ``columns.json``.

    Returns:
        The number of tables written.
    """
    make_folder(folder)
    meaning: dict[str, object] = {}
    count = 0
    for name in tables.names(long=long):
        pieces = _noted(tables.pieces(name), meaning)
        write_pieces(folder / f"{name}.csv", csv_pieces(pieces, label.line))
        count += 1
    content = {"data": label.line, "parameters": dict(label.parameters), "tables": meaning}
    write_json(folder / "columns.json", content)
    return count


def csv_pieces(parts: Iterable[Table], data: str) -> Iterator[str]:
    """Yield tables with the same columns as one text of CSV, piece by piece.

    Args:
        parts: the tables, in order.
        data: who produced the data: the value of the last column.
    """
    for place, part in enumerate(parts):
        yield part.to_csv(data, header=place == 0)


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
