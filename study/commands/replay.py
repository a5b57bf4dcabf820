"""`study replay`: prove that a recording's events follow from its inputs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.terminal import console, errors
from study.errors import StudyError
from study.recording.parts import part_files


def replay(
    files: Annotated[list[Path], typer.Argument(help="Recordings to replay.")],
    verify: Annotated[  # noqa: FBT002
        bool, typer.Option("--verify", help="Compare the events byte for byte.")
    ] = False,
    resimulate: Annotated[  # noqa: FBT002
        bool, typer.Option("--resimulate", help="Also step the task anew and compare.")
    ] = False,
) -> None:
    """Replay recordings' inputs through the session and compare what follows.

    Of a session in several parts one is enough: the others beside it are found.

    Exit status 0: everything agrees. 1: something differs, or a file
    is not whole, so that only a part could be compared.
    """
    if not (verify or resimulate):
        raise StudyError("nothing to do", "Say --verify, --resimulate or both.")
    sessions: dict[tuple[Path, ...], Path] = {}
    for file in files:
        if not file.is_file():
            raise StudyError(f"no recording {file}", "Give the path of an .mcap file.")
        sessions.setdefault(tuple(part_files(file)), file)
    whole = True
    for file in sessions.values():
        if len(sessions) > 1:
            console.print(f"[bold]{escape(file.name)}[/]")
        whole &= _replayed(file, resimulate=resimulate)
    if not whole:
        raise typer.Exit(1)


def _replayed(file: Path, *, resimulate: bool) -> bool:
    """Replay one session, say what was found, and return whether all agrees."""
    from study.verification import verify  # noqa: PLC0415 - slow to import

    verdict = verify(file, resimulate=resimulate)
    console.print(f"{verdict.inputs} inputs replayed, {verdict.events} events compared")
    if verdict.parts > 1:
        console.print(
            f"The session has {verdict.parts} parts; fleet runs broken off and left out: "
            f"{verdict.left_out_trials}"
        )
    if resimulate:
        console.print(
            f"{verdict.resimulated} fleet answers stepped anew, "
            f"largest difference of a state {verdict.largest_deviation:g}"
        )
    if not verdict.matches:
        errors.print(f"[bold red]Different:[/] {escape(verdict.difference)}")
        return False
    if verdict.problems:
        errors.print("[bold yellow]Not whole:[/] what can be read agrees, but")
        for problem in verdict.problems:
            errors.print(f"  {escape(problem)}")
        return False
    console.print("[green]Identical:[/] every event follows from the inputs, byte for byte.")
    return True
