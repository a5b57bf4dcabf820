"""`study simulate`: the same session with simulated participants."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.composing import lock_warning
from study.commands.deviations import tell_failed_fits
from study.commands.progress import followed
from study.commands.terminal import console, errors
from study.loading import load_protocol
from study.output_option import folder_wanted
from study.simulated.parameters import Driver, stated_parameters
from study.workers import checked_jobs

Stated = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="A parameter that all simulated participants have, NAME=VALUE, such as "
        "glance_tiles=3; several times for several. The others are drawn.",
    ),
]


def simulate(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    participants: Annotated[
        int | None, typer.Option(min=1, max=10_000, help="How many; default: as planned.")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the study.")] = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", callback=folder_wanted, help="Folder of the recordings."),
    ] = Path("recordings/simulated"),
    jobs: Annotated[int, typer.Option(min=-1, help="Processes at once; -1: all cores.")] = -1,
    driver: Annotated[
        Driver,
        typer.Option(help="Who drives: a crude person's plan, or the user trained on the task."),
    ] = "planner",
    stated: Stated = None,
) -> None:
    """Run simulated participants through the whole study, on all cores, without a window."""
    simulate_with_progress(protocol, participants, seed, output, jobs, driver, stated or ())


def simulate_with_progress(
    protocol: str,
    participants: int | None,
    seed: int | None,
    output: Path,
    jobs: int,
    driver: Driver = "planner",
    stated: Sequence[str] = (),
) -> list[Path]:
    """Simulate a study and show how far it is; return the recordings."""
    parameters = stated_parameters(stated)
    from study.commands.simulating import (  # noqa: PLC0415 - slow to import
        default_seed,
        simulate_study,
    )
    from study.shell.fleet import check_installed  # noqa: PLC0415 - slow to import

    checked_jobs(jobs)
    loaded = load_protocol(protocol)
    check_installed(loaded.protocol.task.name, loaded.protocol.task.parameters)
    if warning := lock_warning(loaded):
        errors.print(f"[yellow]{escape(warning)}[/]")
    count = participants or loaded.protocol.study.planned_participants
    study_seed = default_seed(loaded) if seed is None else seed
    finished = simulate_study(str(loaded.path), count, study_seed, output, jobs, driver, parameters)
    sessions = list(
        followed("Simulated participants", finished, count, name=lambda session: session.path.name)
    )
    tell_failed_fits([session.failed_fits for session in sessions])
    people = "participant" if count == 1 else "participants"
    where = escape(str(output))
    console.print(f"{count} simulated {people} (seed {study_seed}), recordings in {where}")
    return [session.path for session in sessions]
