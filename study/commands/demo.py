"""`study demo`: twelve simulated participants through the whole study, and its report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from study.commands.simulate import simulate_with_progress
from study.commands.terminal import console
from study.errors import StudyError
from study.recording.reader import read_recording


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

    _clear(recordings)
    simulate_with_progress(protocol, participants, seed, recordings, jobs=-1)
    with console.status("Writing the report"):
        path = write_report([recordings], report)
    console.print(f"[bold]Report:[/] {path.resolve()}")


def _clear(folder: Path) -> None:
    """Remove an earlier demo's recordings, and nothing that a person made."""
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    for path in found:
        if not _is_simulated(path):
            raise StudyError(
                f"{path} is no recording of a simulated participant",
                "Give another folder with --recordings; the demo empties the one it is given.",
            )
    for path in found:
        path.unlink()


def _is_simulated(path: Path) -> bool:
    try:
        return read_recording(path).metadata.get("operator_kind") == "simulated"
    except (StudyError, OSError):
        return False
