"""The option ``--version`` of both command lines."""

from __future__ import annotations

import importlib.metadata
import platform
from typing import Annotated

import typer


def _print_version(asked: bool) -> None:  # noqa: FBT001 - so Typer calls it
    if asked:
        version = importlib.metadata.version("scaled-autonomy")
        typer.echo(f"scaled-autonomy {version} (Python {platform.python_version()})")
        raise typer.Exit


VersionOption = Annotated[
    bool,
    typer.Option(
        "--version",
        callback=_print_version,
        is_eager=True,
        help="Print the version and end.",
    ),
]
