"""`study whatif`: other scorers, asked about recorded choices."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from study.commands.terminal import console, errors
from study.errors import StudyError
from study.output_option import folder_wanted
from study.pool_option import PoolProtocols

if TYPE_CHECKING:
    from study.whatif.running import Findings
    from study.whatif.sessions import ChoiceSession


def whatif(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings, or folders of them.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", callback=folder_wanted, help="Folder of the tables.")
    ],
    scorer: Annotated[
        list[str] | None,
        typer.Option(
            help="Whom to ask, several times for several: own (each participant's own), a scorer "
            "of the protocol or of study/scorers, a recording (FILE.mcap or FILE.mcap#NAME), or "
            "weights (FILE.safetensors); NAME=FILE gives a file a name. Default: own."
        ),
    ] = None,
    cross_validate: Annotated[
        int,
        typer.Option(
            min=0,
            max=50,
            help="Also fit each own scorer anew with each of so many parts of its trials held "
            "out; 0: not.",
        ),
    ] = 0,
    regret_choices: Annotated[
        int,
        typer.Option(
            min=0, max=100_000, help="Choices of each participant that are rolled out; 0: none."
        ),
    ] = 50,
    horizon: Annotated[
        int, typer.Option(min=1, max=10_000, help="Timesteps that are rolled out.")
    ] = 40,
    draws: Annotated[
        int, typer.Option(min=1, max=1000, help="Futures averaged over, the same for all robots.")
    ] = 4,
    driver: Annotated[
        str,
        typer.Option(
            help="Who drives the robot taken over: trained, demonstrations (the participant's "
            "own), or a file of study train-user."
        ),
    ] = "trained",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the futures.")] = 0,
    *,
    pool_protocols: PoolProtocols = False,
) -> None:
    """Ask scorers about the choices in recordings, and write tables for `analysis report`.

    How often does a scorer name the robot that the operator chose, how likely does it hold the
    choice, where do they part, and what would another choice have earned?
    """
    from study.commands.composing import versions  # noqa: PLC0415 - slow to import
    from study.whatif.regret import RegretSettings  # noqa: PLC0415
    from study.whatif.running import ask  # noqa: PLC0415
    from study.whatif_files import write_what_if  # noqa: PLC0415

    if cross_validate == 1:
        raise StudyError(
            "--cross-validate: 1 given",
            "With one part nothing is left to fit to: give 2 or more, or 0 for none.",
        )
    asked = scorer or ["own"]
    regret = RegretSettings(horizon, draws, regret_choices, driver, seed)
    with console.status("Reading recordings") as status:
        sessions = open_sessions(recordings, pool=pool_protocols)
        found = ask(
            sessions,
            asked,
            parts=cross_validate,
            regret=regret if regret_choices else None,
            progress=status.update,
        )
        status.update("Writing tables")
        settings: dict[str, Any] = {
            "scorers": asked,
            "cross_validate": cross_validate,
            "regret_choices": regret_choices,
            "horizon": horizon,
            "draws": draws,
            "driver": driver,
            "seed": seed,
            "notes": list(found.notes),
        }
        write_what_if(output, found.tables, settings, versions())
    _say(found, sessions)
    where = escape(str(output))
    console.print(f"Tables: {where}")
    given = " ".join(str(path) for path in recordings)
    console.print(f"Report: analysis report {escape(given)} --whatif {where} -o FOLDER")


def open_sessions(recordings: list[Path], *, pool: bool = False) -> list[ChoiceSession]:
    """Open recordings as the report does, and gather the choices of each session.

    Raises:
        StudyError: nothing can be used.
    """
    from analysis.recordings import load_recordings  # noqa: PLC0415 - slow to import
    from study.whatif.sessions import open_choices  # noqa: PLC0415

    study = load_recordings(recordings, pool=pool)
    for item in study.set_aside:
        errors.print(escape(str(item)))
    return [
        open_choices(session.opened, session.recording, session.files, session.trials)
        for session in study.sessions
    ]


def _say(found: Findings, sessions: list[ChoiceSession]) -> None:
    for text in found.notes:
        errors.print(f"[yellow]{escape(text)}[/]")
    choices = sum(len(run.chosen) for session in sessions for run in session.runs)
    people = f"{len(sessions)} participant{'' if len(sessions) == 1 else 's'}"
    console.print(f"{choices} choices of {people}")
    trials = found.tables["trials"]
    for fitted, of_what in ((False, "after the own scorers were fitted"), (True, "before that")):
        rows = [
            at
            for at, seen in enumerate(trials["seen"])
            if trials["fitted"][at] == fitted and not seen
        ]
        for name in dict.fromkeys(trials["scorer"][at] for at in rows):
            mine = [at for at in rows if trials["scorer"][at] == name]
            count = sum(trials["choices"][at] for at in mine)
            hits = sum(trials["choices"][at] * trials["agreement"][at] for at in mine)
            luck = sum(trials["choices"][at] * trials["chance_agreement"][at] for at in mine)
            console.print(
                f"  {escape(name)}: named {hits / count:.2f} of {count} choices made {of_what} "
                f"(chance {luck / count:.2f})"
            )
