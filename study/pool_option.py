"""``--pool-protocols``, for commands of both programs that read recordings."""

from __future__ import annotations

from typing import Annotated

import typer

PoolProtocols = Annotated[
    bool,
    typer.Option(
        "--pool-protocols",
        help="Pool different protocols, or people and simulated participants.",
    ),
]
