"""`study export-foxglove`: a recording with a scene that Foxglove can draw."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from study.commands.terminal import console, errors
from study.errors import StudyError

DEFAULT_FOLDER = Path("reports") / "foxglove"
_SOMETHING_MISSING = 3


def export_foxglove(
    file: Annotated[Path, typer.Argument(help="Recording, whole or damaged; only read.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="New file; default: reports/foxglove/NAME.mcap."),
    ] = None,
    rate: Annotated[
        float, typer.Option(min=0.1, max=100, help="Scene messages a second, at most.")
    ] = 5.0,
) -> None:
    """Write a recording anew with a scene of map and robots, for Foxglove.

    Of a session in several parts give any one: the others beside it are
    found, and the new file holds them all. The original is never altered.

    Exit status 0: all is exported. 3: something of the session is missing;
    what can be read is exported. 2: it is no recording, or the new file
    cannot be written.
    """
    from study.enrolment.importing import note_export  # noqa: PLC0415
    from study.foxglove.export import export  # noqa: PLC0415 - slow to import
    from study.foxglove.layout import layout_path  # noqa: PLC0415
    from study.recording.parts import base_name  # noqa: PLC0415

    target = output
    if target is None:
        target = DEFAULT_FOLDER / f"{base_name(file)}.mcap"
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    with Progress(*columns, TimeElapsedColumn(), console=errors, transient=True) as progress:
        task = progress.add_task("Exporting")

        def show(done: int, total: int) -> None:
            progress.update(task, completed=done, total=total)

        done = export(file, target, rate, show)
    try:
        note_export(file, done.path)
    except StudyError as error:
        errors.print(f"[yellow]The register does not know of this file:[/] {escape(str(error))}")
    console.print(
        f"{done.records} records and {done.scene_messages} scene messages "
        f"written to {escape(str(done.path))}"
    )
    console.print(f"Layout to import in Foxglove: {escape(str(layout_path()))}")
    if done.without_scene:
        errors.print(f"[yellow]No robots are drawn:[/] {escape(done.without_scene)}")
    if done.unknown_records:
        errors.print(
            f"[yellow]{done.unknown_records} records of topics that this version does not know "
            "are left out.[/]"
        )
    if done.problems:
        errors.print("[bold yellow]Not whole:[/] what can be read is exported, but")
        for problem in done.problems:
            errors.print(f"  {escape(problem)}")
        raise typer.Exit(_SOMETHING_MISSING)
