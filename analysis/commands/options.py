"""Options that several commands take, in the same words."""

from __future__ import annotations

from typing import Annotated

import typer

Long = Annotated[
    bool,
    typer.Option(
        "--long", help="Also those with a row for each timestep, or each robot and timestep."
    ),
]
