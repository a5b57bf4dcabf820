"""`analysis export`: recordings to a folder that other programs read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from analysis.commands.options import Long
from analysis.commands.writing import open_recordings
from analysis.tables.study_tables import StudyTables
from study.output_option import folder_wanted
from study.pool_option import PoolProtocols


def export(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings, or folders of them.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", callback=folder_wanted, help="Folder for the export.")
    ],
    *,
    long: Long = False,
    parquet: Annotated[
        bool, typer.Option("--parquet", help="Also every table as Parquet; needs pyarrow.")
    ] = False,
    minari: Annotated[
        bool,
        typer.Option(
            "--minari",
            help="Also every episode, and the demonstrations alone, as Minari data sets; needs "
            "minari and h5py.",
        ),
    ] = False,
    pool_protocols: PoolProtocols = False,
) -> None:
    """Write a Psych-DS folder, a wide CSV for JASP and jamovi, and more on request."""
    from analysis.export import minari_data, psych_ds  # noqa: PLC0415 - slow to import
    from analysis.results import compute_results  # noqa: PLC0415 - slow to import

    console = Console(stderr=True, soft_wrap=True)
    study = open_recordings(recordings, console, pool=pool_protocols)
    with console.status("Exporting"):
        results = compute_results(study, StudyTables(study))
        if minari:
            minari_data.require_minari()
        written = psych_ds.export(results, output, long=long, parquet=parquet)
        data_sets = minari_data.export(study, output) if minari else ()
    console.print(
        f"Wrote {len(written.files)} files to {output}. The rows of all {len(written.counts)} "
        "tables that recordings have counts for agree with them.",
        markup=False,
        highlight=False,
    )
    for made in data_sets:
        console.print(
            f"Minari data set {made.data_set}: {made.episodes} episodes, {made.steps} steps; "
            f"load it with MINARI_DATASETS_PATH={output / minari_data.FOLDER}",
            markup=False,
            highlight=False,
        )
