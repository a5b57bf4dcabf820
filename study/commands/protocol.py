"""`study protocol`: write the protocol that a recording holds to a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.terminal import console
from study.errors import RecordingError, StudyError
from study.events.inputs import SessionOpened
from study.recording.parts import read_session


def protocol(
    file: Annotated[Path, typer.Argument(help="Recording, or any part of a session.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="New file; default: NAME.toml in this folder."),
    ] = None,
) -> None:
    """Write the protocol of a recording to a file, byte for byte as the session began with it."""
    if not file.is_file():
        raise StudyError(f"no recording {file}", "Give the path of an .mcap file.")
    recording = read_session(file)
    opened = next((r for _, r in recording.records(SessionOpened.topic)), None)
    if not isinstance(opened, SessionOpened):
        raise RecordingError(
            f"{file.name} does not get as far as its protocol",
            "Put the first part of the session beside it.",
        )
    path = output or Path(f"{recording.path.name.split('.')[0]}.toml")
    try:
        with path.open("x", encoding="utf-8", newline="") as stream:
            try:
                stream.write(opened.protocol_toml)
                stream.flush()
            except OSError:
                # What is half there would be in the way of the next try.
                path.unlink(missing_ok=True)
                raise
    except FileExistsError as error:
        raise StudyError(f"{path} exists already", "Name another file with --output.") from error
    except OSError as error:
        raise StudyError(f"{path} cannot be written: {error.strerror}") from error
    console.print(f"Protocol of {escape(opened.participant)}: {escape(str(path))}")
    console.print(f"sha256 {opened.protocol_sha256[:12]}")
