"""`study gallery`: every screen of a protocol as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from study.commands.terminal import console
from study.loading import load_protocol
from study.messages import SOURCE, messages_for
from study.output_option import folder_wanted
from study.shell.pygame_check import require_pygame_ce


def gallery(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", callback=folder_wanted, help="Folder of the pictures.")
    ] = Path("gallery"),
    size: Annotated[
        list[str] | None, typer.Option(help="Size of the pictures, 1280x960 if none; repeatable.")
    ] = None,
    ui_scale: Annotated[
        list[float] | None, typer.Option(help="UI scale from 1 to 2, 1 if none; repeatable.")
    ] = None,
    locale: Annotated[
        list[str] | None, typer.Option(help='Language, "en" if none; repeatable. "pseudo" tests.')
    ] = None,
) -> None:
    """Draw every screen that a participant sees to PNG files, without a window.

    A simulated participant goes through the protocol; each screen is drawn as it was. With more
    than one size, scale or language each combination has a folder of its own.
    """
    from study.commands.picturing import Look, draw_gallery  # noqa: PLC0415 - pygame is slow
    from study.commands.run import parse_size  # noqa: PLC0415
    from study.shell.window import check_ui_scale  # noqa: PLC0415

    require_pygame_ce()
    loaded = load_protocol(protocol)
    looks = [
        Look(parse_size(shown) or (1280, 960), check_ui_scale(scale), messages_for(language))
        for language in locale or [SOURCE]
        for shown in size or [""]
        for scale in ui_scale or [1.0]
    ]
    pictures = draw_gallery(loaded, output, looks)
    console.print(f"{len(pictures)} pictures in {output}")
