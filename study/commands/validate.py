"""`study validate`: check a protocol and say how long it takes."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.markup import escape
from rich.table import Table

from study.commands.terminal import console
from study.durations import dwell_seconds, expected_minutes
from study.experiment.protocol import is_experiment, load_experiment
from study.loading import find_protocol, load_protocol, missing_extra, read_text
from study.remarks import remark_on_consent, remarks


def validate(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
) -> None:
    """Check a protocol file; print its dwell in seconds and the minutes of each stage.

    Of an experiment's file: how many trials it has, and in which worlds.
    """
    if is_experiment(read_text(find_protocol(protocol))):
        _validate_experiment(protocol)
        return
    loaded = load_protocol(protocol)
    console.print(f"[green]Valid:[/] {escape(str(loaded.path))} (sha256 {loaded.sha256[:12]})")
    if missing := missing_extra(loaded.protocol.task.name, loaded.protocol.task.parameters):
        console.print(f"[yellow]To run it:[/] {escape(missing)}")
    told = remarks(loaded.protocol, loaded.description.horizon)
    for remark in filter(None, [*told, remark_on_consent(loaded.protocol)]):
        console.print(f"[yellow]To consider:[/] {escape(remark)}")
    for condition, seconds in dwell_seconds(loaded.protocol):
        console.print(
            f"Condition {condition.name}: dwell {condition.dwell} timesteps = {seconds:.2f} s"
        )
    table = Table("Stage", "About", title="Expected minutes", title_justify="left")
    total = 0.0
    for stage, minutes in expected_minutes(loaded.protocol, loaded.description.horizon):
        total += minutes
        table.add_row(stage, f"{minutes:.1f}" if minutes >= 0.1 else "under 0.1")
    table.add_row("Together", f"{total:.1f}", style="bold")
    console.print(table)
    console.print(f"Assumptions marked: {len(loaded.protocol.assumptions)}")


def _validate_experiment(given: str) -> None:
    loaded = load_experiment(given)
    protocol = loaded.protocol
    console.print(f"[green]Valid:[/] {escape(str(loaded.path))} (sha256 {loaded.sha256[:12]})")
    seeds = protocol.seeds
    console.print(
        f"An experiment of {protocol.experiment.trials} trials; worlds: development seed "
        f"{seeds.development}, held-out seed {seeds.held_out}"
    )
    console.print(f"Assumptions marked: {len(protocol.assumptions)}")
