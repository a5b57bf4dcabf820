"""`study recover`: salvage a torn or damaged recording into a new file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.terminal import console, errors
from study.recording.parts import SALVAGED

_SOMETHING_LOST = 3


def recover(
    file: Annotated[Path, typer.Argument(help="Torn or damaged recording; only read.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="New file; default: NAME_salvaged.mcap beside it."),
    ] = None,
) -> None:
    """Salvage a torn or damaged recording into a new file, and say what is lost.

    Exit status 0: nothing is lost. 3: something is. 2: it is no recording,
    holds no record that can be read, or the new file cannot be written.
    The original is never altered.
    """
    from study.recording.salvage import salvage  # noqa: PLC0415 - slow to import

    done = salvage(file, output or salvaged_path(file))
    for problem in done.problems:
        errors.print(f"  {escape(problem)}")
    console.print(f"{done.records} records salvaged into {escape(str(done.path))}")
    if done.nothing_lost:
        console.print("[green]Nothing is lost.[/]")
        return
    known = [loss.count for loss in done.losses if loss.count is not None]
    number = f"{sum(known)} records" if known else "Records"
    unknown = len(known) < len(done.losses)
    if done.losses:
        more = " and an unknown number at the end" if unknown and known else ""
        where = " at the end, nobody knows how many," if unknown and not known else ""
        errors.print(f"[bold yellow]Lost:[/] {number}{more}{where} as said above.")
    else:
        errors.print("[bold yellow]Lost:[/] no record, but what is said above.")
    raise typer.Exit(_SOMETHING_LOST)


def salvaged_path(file: Path) -> Path:
    """Return the default name of the file salvaged from another."""
    name = file.name.removesuffix(".part").removesuffix(".mcap")
    return file.with_name(f"{name}{SALVAGED}.mcap")
