"""How far a long command says that it is."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from study.commands.progress import LINES, followed


def said(total: int, there: int = 0, *, terminal: bool = False) -> list[str]:
    """Return the lines that are seen of so many pieces, some of them there before."""
    file = io.StringIO()
    console = Console(file=file, force_terminal=terminal, highlight=False, soft_wrap=True)
    pieces = range(there, total)
    assert list(followed("Trials", pieces, total, there=there, on=console)) == list(pieces)
    return file.getvalue().splitlines()


@pytest.mark.parametrize("total", [1, 2, 19, 20, 21, 250, 10_000])
def test_a_file_gets_few_lines_and_the_last(total: int) -> None:
    """However many pieces there are, some lines tell of them, spread evenly."""
    lines = said(total)
    assert len(lines) == min(total, LINES)
    assert lines[-1] == f"Trials, {total} of {total}"
    numbers = [int(line.split()[1]) for line in lines]
    gaps = [after - before for before, after in zip([0, *numbers], numbers, strict=False)]
    assert max(gaps) - min(gaps) <= 1


def test_what_was_there_counts_as_finished() -> None:
    """A run that is continued goes on counting where the one before ended."""
    assert said(4, there=2) == ["Trials, 3 of 4", "Trials, 4 of 4"]
    assert said(4, there=4) == []


def test_pieces_with_names_have_a_line_each() -> None:
    """Names are said as they are, brackets included."""
    file = io.StringIO()
    pieces = [f"[bold]{number}" for number in range(30)]
    console = Console(file=file, soft_wrap=True)
    assert list(followed("People", pieces, 30, on=console, name=lambda piece: piece)) == pieces
    lines = file.getvalue().splitlines()
    assert lines == [f"People, {n + 1} of 30: [bold]{n}" for n in range(30)]


def test_a_terminal_sees_a_bar_instead() -> None:
    """Nothing is scrolled away by a line a piece."""
    text = "\n".join(said(100, terminal=True))
    assert "100/100" in text
    assert "Trials, " not in text
