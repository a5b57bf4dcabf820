"""`study plan`: how many participants, and how many trials?"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.simulate import Stated
from study.commands.terminal import console, errors
from study.errors import StudyError
from study.loading import load_protocol
from study.output_option import folder_wanted
from study.pool_option import PoolProtocols
from study.simulated.parameters import Driver
from study.workers import checked_jobs

EFFECT = "Assumed effect"
LOSSES = "What is lost"
PILOT = "Pilot"
GRID = "Sizes and simulation"

_Number = float | None


def plan(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    effect: Annotated[
        list[str] | None,
        typer.Option(
            help="Effect to find, points of team reward a trial: POINTS, or with three or more "
            "conditions NAME=POINTS for each but the reference. Default: equivalence_bound of the "
            "protocol, then the pilot's.",
            rich_help_panel=EFFECT,
        ),
    ] = None,
    effect_sd: Annotated[
        _Number,
        typer.Option(
            help="SD between participants of the true effect, points; default: the pilot's.",
            rich_help_panel=EFFECT,
        ),
    ] = None,
    trial_sd: Annotated[
        _Number,
        typer.Option(
            help="SD of a participant's trials under one condition, points; default: the pilot's.",
            rich_help_panel=EFFECT,
        ),
    ] = None,
    level_sd: Annotated[
        _Number,
        typer.Option(
            help="SD between participants of their level, points; default: the pilot's, or as "
            "much as trials scatter.",
            rich_help_panel=EFFECT,
        ),
    ] = None,
    period: Annotated[
        _Number,
        typer.Option(
            help="Points by which each block exceeds the one before; default: the pilot's, or 0.",
            rich_help_panel=EFFECT,
        ),
    ] = None,
    learning: Annotated[
        _Number,
        typer.Option(
            help="Points by which each trial exceeds the one before in its block; default: the "
            "pilot's, or 0.",
            rich_help_panel=EFFECT,
        ),
    ] = None,
    carry_over: Annotated[
        _Number,
        typer.Option(
            help="Points added to a block that follows another condition than the reference; "
            "default: 0.",
            rich_help_panel=EFFECT,
        ),
    ] = None,
    drop_out: Annotated[
        _Number,
        typer.Option(
            help="Part of the participants who leave, at any trial; default: 0.",
            rich_help_panel=LOSSES,
        ),
    ] = None,
    missing: Annotated[
        _Number,
        typer.Option(
            help="Part of the trials lost one by one; default: 0.", rich_help_panel=LOSSES
        ),
    ] = None,
    recordings: Annotated[
        list[Path] | None,
        typer.Option(
            "--from",
            help="Recordings of a pilot, or folders of them, several times for several.",
            rich_help_panel=PILOT,
        ),
    ] = None,
    sessions: Annotated[
        int,
        typer.Option(
            min=0,
            max=1000,
            help="Simulate a pilot of so many sessions through this protocol.",
            rich_help_panel=PILOT,
        ),
    ] = 0,
    driver: Annotated[
        Driver,
        typer.Option(help="Who drives in a simulated pilot.", rich_help_panel=PILOT),
    ] = "planner",
    stated: Stated = None,
    participants: Annotated[
        str,
        typer.Option(
            help="Numbers of participants, by commas; default: about what the closed form names.",
            rich_help_panel=GRID,
        ),
    ] = "",
    trials: Annotated[
        str,
        typer.Option(
            help="Numbers of trials a condition, by commas; default: half, all and twice of the "
            "protocol's.",
            rich_help_panel=GRID,
        ),
    ] = "",
    alpha: Annotated[float, typer.Option(help="Level of the test.", rich_help_panel=GRID)] = 0.05,
    power: Annotated[float, typer.Option(help="Power wanted.", rich_help_panel=GRID)] = 0.8,
    studies: Annotated[
        int,
        typer.Option(
            min=100, max=1_000_000, help="Studies simulated of each size.", rich_help_panel=GRID
        ),
    ] = 5000,
    model_studies: Annotated[
        int,
        typer.Option(
            min=50,
            max=1_000_000,
            help="The same where trials may be missing, and each study needs a mixed model.",
            rich_help_panel=GRID,
        ),
    ] = 400,
    seed: Annotated[
        int, typer.Option(min=0, help="Of all that is simulated.", rich_help_panel=GRID)
    ] = 0,
    jobs: Annotated[
        int,
        typer.Option(min=-1, help="Processes at once; -1: all cores.", rich_help_panel=GRID),
    ] = -1,
    scheduler: Annotated[
        str,
        typer.Option(help="Run on a Dask cluster: address of its scheduler.", rich_help_panel=GRID),
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            callback=folder_wanted,
            help="Folder of report and tables; default: reports/NAME_plan.",
        ),
    ] = None,
    *,
    pool_protocols: PoolProtocols = False,
) -> None:
    """Plan a study: the smallest number of participants and trials that finds an effect.

    Power by closed form, and by simulation through the very test that the report will make. What
    is not given is estimated from a pilot, of recordings or simulated.
    """
    # Statistics are slow to import: no other command should wait for them.
    from analysis.planning.files import write_plan  # noqa: PLC0415
    from analysis.planning.plan import make_plan  # noqa: PLC0415
    from analysis.planning.stated import Given, settle  # noqa: PLC0415
    from analysis.planning.words import details, headline, warnings  # noqa: PLC0415
    from study.commands.planning import (  # noqa: PLC0415
        Workers,
        find_pilot,
        given_grid,
        planned_study,
        power_table,
        wanted_of,
    )

    # What was given is looked at before a pilot takes its time.
    checked_jobs(jobs)
    if not 0 < power < 1:
        raise StudyError(f"--power: {power:g} given", "It lies between 0 and 1, such as 0.8.")
    loaded = load_protocol(protocol)
    study = planned_study(loaded)
    sizes = given_grid(study, participants, trials)
    folder = output or Path("reports") / f"{loaded.protocol.study.name}_plan"
    given = Given(
        tuple(effect or ()), effect_sd, trial_sd, level_sd, period, learning, carry_over, drop_out,
        missing, alpha,
    )  # fmt: skip
    pilot = find_pilot(
        loaded,
        recordings or [],
        sessions,
        folder / "pilot",
        seed=seed,
        jobs=jobs,
        driver=driver,
        stated=stated or (),
        pool=pool_protocols,
    )
    assumptions, rows = settle(study, given, pilot)
    wanted = wanted_of(
        study,
        assumptions,
        sizes,
        power=power,
        studies=studies,
        model_studies=model_studies,
        seed=seed,
    )
    found = make_plan(assumptions, wanted, pilot, Workers(jobs, scheduler))
    path = write_plan(found, study, rows, folder)
    console.print(power_table(found))
    console.print(f"[bold]{escape(headline(found))}[/]")
    for sentence in details(found, study):
        console.print(f"  {escape(sentence)}")
    for sentence in warnings(found, study, rows):
        errors.print(f"[yellow]{escape(sentence)}[/]")
    console.print(f"Report: {escape(str(path))}")
