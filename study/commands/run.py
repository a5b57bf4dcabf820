"""`study run`: seat a person at a keyboard."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.composing import check_participant
from study.commands.recorded_scorers import parse_overrides
from study.commands.terminal import console, errors
from study.errors import StudyError
from study.loading import load_protocol
from study.shell.pygame_check import require_pygame_ce


def run(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    participant: Annotated[
        str, typer.Option("--participant", "-p", help="Pseudonymous id, such as P01.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder of the recordings.")
    ] = Path("recordings"),
    order: Annotated[
        str, typer.Option(help="Conditions in order, by commas; default: the least used one.")
    ] = "",
    seed: Annotated[int | None, typer.Option(min=0, max=2**63 - 1, help="Session seed.")] = None,
    size: Annotated[str, typer.Option(help="Window size, such as 1280x960.")] = "",
    fullscreen: Annotated[bool, typer.Option("--fullscreen", help="Fill the screen.")] = False,  # noqa: FBT002
    again: Annotated[  # noqa: FBT002
        bool, typer.Option("--again", help="Allow a participant who has a recording.")
    ] = False,
    scorer: Annotated[
        list[str] | None,
        typer.Option(help="NAME=PATH: take a recorded scorer from that recording."),
    ] = None,
    resume: Annotated[  # noqa: FBT002
        bool, typer.Option("--resume", help="Go on with a session that broke off.")
    ] = False,
) -> None:
    """Run one session with a person at the keyboard, in a window."""
    from study.commands.resuming import find_boundary  # noqa: PLC0415 - slow to import
    from study.commands.running import (  # noqa: PLC0415 - pygame is slow to import
        assign,
        resume_session,
        run_session,
    )

    require_pygame_ce()
    loaded = load_protocol(protocol)
    window_size = parse_size(size)
    scorers = parse_overrides(scorer or [])
    if resume:
        if again or order or seed is not None:
            raise StudyError(
                "--resume keeps the session's order and seed, and begins no other session",
                "Leave out --again, --order and --seed.",
            )
        boundary = find_boundary(loaded, check_participant(participant), output)
        opened = boundary.opened
        console.print(
            f"Participant [bold]{opened.participant}[/], order {' then '.join(opened.order)}: "
            "going on at the last stage entered. Escape pauses."
        )
        paths, complete = resume_session(
            loaded, boundary, output, size=window_size, fullscreen=fullscreen, scorers=scorers
        )
    else:
        assignment = assign(loaded, participant, output, order=order, seed=seed, again=again)
        console.print(
            f"Participant [bold]{assignment.participant}[/], "
            f"order {' then '.join(assignment.order)}. Escape pauses."
        )
        paths, complete = run_session(
            loaded, assignment, output, size=window_size, fullscreen=fullscreen, scorers=scorers
        )
    for path in paths:
        console.print(f"Recorded in {escape(str(path))}")
    if not paths:
        errors.print("[yellow]No recording: the participant declined, or had it erased.[/]")
        raise typer.Exit(3)
    if not complete:
        errors.print("[yellow]The session was ended early; the recording holds what there was.[/]")
        raise typer.Exit(3)


def parse_size(given: str) -> tuple[int, int] | None:
    """Return (width, height) of "1280x960"; None if empty.

    Raises:
        StudyError: it is no size.
    """
    if not given:
        return None
    width, _, height = given.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise StudyError(f'window size "{given}"', "Give width x height in pixels: 1280x960.")
    return int(width), int(height)
