"""`study gallery`: every screen of a protocol as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from study.commands.terminal import console
from study.loading import load_protocol
from study.shell.pygame_check import require_pygame_ce


def gallery(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the pictures.")] = Path(
        "gallery"
    ),
    size: Annotated[str, typer.Option(help="Size of the pictures, such as 1280x960.")] = "1280x960",
) -> None:
    """Draw every screen that a participant sees to PNG files, without a window.

    A simulated participant goes through the protocol; each screen is drawn as it was.
    """
    from study.commands.picturing import draw_gallery  # noqa: PLC0415 - pygame is slow to import
    from study.commands.run import parse_size  # noqa: PLC0415

    require_pygame_ce()
    loaded = load_protocol(protocol)
    pictures = draw_gallery(loaded, output, parse_size(size) or (1280, 960))
    console.print(f"{len(pictures)} pictures in {output}")
