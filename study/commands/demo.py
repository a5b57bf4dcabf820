"""`study demo`: twelve simulated participants through the whole study, and its report."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

import typer

from study.commands.simulate import simulate_with_progress
from study.commands.terminal import console
from study.errors import StudyError


def demo(
    recordings: Annotated[
        Path, typer.Option(help="Folder of the recordings; emptied of earlier demo recordings.")
    ] = Path("recordings/demo"),
    report: Annotated[Path, typer.Option("--report", help="Folder of the report.")] = Path(
        "reports/demo"
    ),
    protocol: Annotated[str, typer.Option(help="Protocol file, or name of a shipped one.")] = (
        "scaled_autonomy"
    ),
    participants: Annotated[
        int | None, typer.Option(min=1, max=10_000, help="How many; default: as planned.")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the study.")] = None,
) -> None:
    """Simulate the paper's study with twelve participants and write its report."""
    from analysis.commands.report import write_report  # noqa: PLC0415 - slow to import

    _clear(recordings)
    simulate_with_progress(protocol, participants, seed, recordings, jobs=-1)
    with console.status("Writing the report"):
        path = write_report([recordings], report)
    console.print(f"[bold]Report:[/] {path.resolve()}")


def _clear(folder: Path) -> None:
    """Remove an earlier demo's recordings, and nothing that a person made."""
    marker = folder / ".demo"
    if folder.is_dir() and any(folder.iterdir()):
        if not marker.is_file():
            raise StudyError(
                f"{folder} holds files that no demo wrote",
                "Give another folder with --recordings; recordings are never overwritten.",
            )
        shutil.rmtree(folder)
    folder.mkdir(parents=True, mode=0o700)
    marker.write_text("Recordings of a demonstration; the next one replaces them.\n")
