"""`analysis report`: recordings to one HTML file and its tables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from analysis.commands.writing import open_recordings, write_tables
from analysis.data_label import data_label
from analysis.files import make_folder, write_text
from analysis.tables.study_tables import StudyTables
from study.errors import StudyError
from study.output_option import folder_wanted
from study.pool_option import PoolProtocols
from study.trial_files import is_results


def report(
    recordings: Annotated[
        list[Path], typer.Argument(help="Recordings or folders of them, or results.")
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", callback=folder_wanted, help="Folder for the report.")
    ],
    whatif: Annotated[
        Path | None,
        typer.Option(help="Folder that `study whatif` wrote about these recordings."),
    ] = None,
    *,
    pool_protocols: PoolProtocols = False,
) -> None:
    """Write report.html and tables/*.csv; a report already there is made anew.

    Recordings, or the one folder of an experiment's results.
    """
    console = Console(stderr=True, soft_wrap=True)
    if any(is_results(path) for path in recordings):
        if whatif is not None:
            raise StudyError(
                "--whatif is about recordings, not an experiment's results", "Leave it out."
            )
        path = write_experiment_report(recordings, output)
    else:
        path = write_report(recordings, output, console, pool=pool_protocols, whatif=whatif)
    console.print(f"Report: {path}", markup=False, highlight=False, soft_wrap=True)


def write_report(
    recordings: list[Path],
    output: Path,
    console: Console | None = None,
    *,
    pool: bool = False,
    whatif: Path | None = None,
) -> Path:
    """Build a report and its tables and return the report's path.

    Args:
        recordings: files and folders.
        output: the folder that gets ``report.html`` and ``tables/``.
        console: where progress goes; nowhere if None.
        pool: pool recordings of different protocols.
        whatif: folder that `study whatif` wrote about these recordings; None for none.

    Raises:
        StudyError: recordings or tables cannot be used, or the folder cannot be written.
    """
    # Statistics are slow to import; an error in the arguments should not wait for them.
    from analysis.report import render_report  # noqa: PLC0415
    from analysis.results import compute_results  # noqa: PLC0415
    from analysis.what_if import load_what_if  # noqa: PLC0415

    console = console or Console(quiet=True)
    study = open_recordings(recordings, console, pool=pool)
    tables = StudyTables(study)
    asked = None if whatif is None else load_what_if(whatif, study)
    for note in asked.notes if asked else ():
        console.print(f"What if: {note}", markup=False, highlight=False)
    make_folder(output)
    with console.status("Writing tables"):
        count = write_tables(tables, data_label(study), output / "tables")
    console.print(f"Wrote {count} tables to {output / 'tables'}.", markup=False, highlight=False)
    with console.status("Computing and drawing"):
        page = render_report(compute_results(study, tables), asked)
    path = output / "report.html"
    write_text(path, page)
    return path


def write_experiment_report(folders: list[Path], output: Path) -> Path:
    """Build the report of an experiment and its tables and return the report's path.

    Raises:
        StudyError: there is more than one folder, or its results cannot be used.
    """
    from analysis.experiment.frames import load_experiment  # noqa: PLC0415 - slow to import
    from analysis.experiment.page import render_experiment  # noqa: PLC0415
    from analysis.experiment.summary import write_experiment_tables  # noqa: PLC0415

    if len(folders) > 1:
        raise StudyError(
            f"{len(folders)} paths given; an experiment's report is of one folder of results",
            "Give each folder to a command of its own.",
        )
    experiment = load_experiment(folders[0])
    make_folder(output)
    write_experiment_tables(experiment, output / "tables")
    path = output / "report.html"
    write_text(path, render_experiment(experiment))
    return path
