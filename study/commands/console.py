"""`study console`: watch a running session, and pause, annotate or end it."""

from __future__ import annotations

import importlib.util
import json as json_format
import os
import sys
from typing import Annotated

import typer

from study.errors import StudyError


def console(
    participant: Annotated[
        str, typer.Option("--participant", "-p", help="Whose session; default: the only one.")
    ] = "",
    json: Annotated[  # noqa: FBT002
        bool, typer.Option("--json", help="Print the sessions that run, once, for a program.")
    ] = False,
) -> None:
    """Watch a running session in another terminal; pause, resume, annotate it or end it early.

    Needs the extra `console`. The recording does not depend on it: close it whenever you like.
    """
    if os.name != "posix":
        raise StudyError("`study console` works on Linux and macOS only")
    if json:
        from study.console.finding import find_sessions  # noqa: PLC0415

        found = [each.status for each in find_sessions() if each.status]
        listed = [
            status.model_dump(mode="json")
            for status in found
            if participant in ("", status.facts.participant)
        ]
        sys.stdout.write(json_format.dumps(listed, indent=1) + "\n")
        return
    if importlib.util.find_spec("textual") is None:
        raise StudyError(
            "`study console` needs the package textual, which is not installed",
            "Install it: pip install 'scaled-autonomy[console]'",
        )
    if not sys.stdout.isatty():
        raise StudyError(
            "`study console` needs a terminal to draw in",
            "For a program there is `study console --json`.",
        )
    from study.console.app import ConsoleApp  # noqa: PLC0415 - slow to import

    ConsoleApp(participant).run()
