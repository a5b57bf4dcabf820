"""`analysis tables`: recordings to CSV files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from analysis.commands.options import Long
from analysis.commands.writing import open_recordings, write_tables
from analysis.data_label import data_label
from analysis.tables.study_tables import StudyTables
from study.output_option import folder_wanted
from study.pool_option import PoolProtocols


def tables(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings, or folders of them.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", callback=folder_wanted, help="Folder for the tables.")
    ],
    *,
    long: Long = False,
    pool_protocols: PoolProtocols = False,
) -> None:
    """Write every table as CSV; tables already there are made anew."""
    console = Console(stderr=True, soft_wrap=True)
    study = open_recordings(recordings, console, pool=pool_protocols)
    with console.status("Writing tables"):
        count = write_tables(StudyTables(study), data_label(study), output, long=long)
    console.print(f"Wrote {count} tables to {output}", markup=False, highlight=False)
