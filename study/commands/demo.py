"""`study demo`: twelve simulated participants through the whole study, and its report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from study.commands.clearing import clear_simulated
from study.commands.simulate import simulate_with_progress
from study.commands.terminal import console


def demo(
    recordings: Annotated[
        Path, typer.Option(help="Folder of the recordings; emptied of earlier simulated ones.")
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

    clear_simulated(recordings, "Give another folder with --recordings")
    simulate_with_progress(protocol, participants, seed, recordings, jobs=-1)
    with console.status("Writing the report"):
        path = write_report([recordings], report)
    console.print(f"[bold]Report:[/] {path.resolve()}")
