"""`study experiment`: the paper's simulation experiments."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.progress import followed
from study.commands.terminal import console
from study.output_option import folder_wanted
from study.workers import checked_jobs


def experiment(
    protocol: Annotated[str, typer.Argument(help="Experiment's file, or name of a shipped one.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            callback=folder_wanted,
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
    finished = run_trials(loaded, seeds, missing, folder, jobs=jobs, scheduler=scheduler)
    for _ in followed("Trials", finished, count, there=there):
        pass
    kept = f" ({there} were there)" if there else ""
    worlds = seeds.replace("_", "-")
    trials_run = "1 trial" if count == 1 else f"{count} trials"
    console.print(f"{trials_run}{kept}, {worlds} worlds, results in {escape(str(folder))}")
    console.print(f"Report: analysis report {escape(str(folder))} -o FOLDER")
