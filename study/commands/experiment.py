"""`study experiment`: the paper's simulation experiments."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from study.commands.terminal import console
from study.workers import checked_jobs

LINES = 20
"""How many lines of progress are written to what is no terminal."""


def experiment(
    protocol: Annotated[str, typer.Argument(help="Experiment's file, or name of a shipped one.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder of the results; default: results/NAME, or results/NAME-development.",
        ),
    ] = None,
    trials: Annotated[
        int | None,
        typer.Option(min=1, max=100_000, help="Only the first so many; default: as planned."),
    ] = None,
    jobs: Annotated[int, typer.Option(min=-1, help="Processes at once; -1: all cores.")] = -1,
    scheduler: Annotated[
        str, typer.Option(help="Run on a Dask cluster: address of its scheduler.")
    ] = "",
    *,
    development: Annotated[
        bool,
        typer.Option(
            "--development", help="Worlds that settings are chosen on, not the held-out ones."
        ),
    ] = False,
) -> None:
    """Run an experiment with a synthetic user, a file a trial; what is there is not run again.

    Results do not depend on how many processes or machines ran it.
    """
    from study.experiment.protocol import SeedSet, load_experiment  # noqa: PLC0415 - slow to import
    from study.experiment.running import missing_trials, run_trials  # noqa: PLC0415

    checked_jobs(jobs)
    loaded = load_experiment(protocol)
    plan = loaded.protocol.experiment
    folder = output or Path("results") / (plan.name + ("-development" if development else ""))
    count = plan.trials if trials is None else trials
    seeds: SeedSet = "development" if development else "held_out"
    missing = missing_trials(loaded, seeds, count, folder)
    there = count - len(missing)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    times = (TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, *times, console=console) as progress:
        task = progress.add_task("Trials", total=count, completed=there)
        finished = run_trials(loaded, seeds, missing, folder, jobs=jobs, scheduler=scheduler)
        for number, _ in enumerate(finished, start=there + 1):
            progress.advance(task)
            # A bar in a file is drawn once, at the end: whoever reads it needs lines.
            if not console.is_terminal and number * LINES // count != (number - 1) * LINES // count:
                console.print(f"{number} of {count} trials")
    kept = f" ({there} were there)" if there else ""
    worlds = seeds.replace("_", "-")
    console.print(f"{count} trials{kept}, {worlds} worlds, results in {escape(str(folder))}")
    console.print(f"Report: analysis report {escape(str(folder))} -o FOLDER")
