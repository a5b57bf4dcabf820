"""How far a long command is: a bar in a terminal, lines in a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from study.commands.terminal import console

LINES = 20
"""How many lines are written at the most to what is no terminal: there a bar is seen at the end."""

T = TypeVar("T")


def followed(
    what: str,
    finished: Iterable[T],
    total: int,
    *,
    there: int = 0,
    on: Console = console,
    transient: bool = False,
    name: Callable[[T], str] | None = None,
) -> Iterator[T]:
    """Yield what is finished, and show how far it is.

    Args:
        what: all of it, as in "Trials".
        finished: pieces, as they are finished.
        total: number of pieces.
        there: how many of them were there before.
        on: where it is shown.
        transient: whether the bar goes at the end.
        name: what a piece is called in its line; then each has one. None: they have no names.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    times = (TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(
        *columns, *times, console=on, transient=transient, disable=not on.is_terminal
    ) as progress:
        task = progress.add_task(what, total=total, completed=there)
        for number, piece in enumerate(finished, start=there + 1):
            progress.advance(task)
            due = name is not None or number * LINES // total > (number - 1) * LINES // total
            if due and not on.is_terminal:
                called = "" if name is None else f": {name(piece)}"
                on.print(escape(f"{what}, {number} of {total}{called}"))
            yield piece
