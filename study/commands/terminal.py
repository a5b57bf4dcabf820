"""How the commands speak: Rich on standard error, one message an error, no traceback."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from study.errors import StudyError
from study.starting import stopped_in_a_line

console = Console(highlight=False, soft_wrap=True)
errors = Console(stderr=True, highlight=False, soft_wrap=True)


def shown_path(path: Path) -> str:
    """Return a path as it is shortest to say: from the present folder, if it lies in it."""
    here = Path.cwd()
    return escape(str(path.relative_to(here) if path.is_relative_to(here) else path))


def tell(error: StudyError) -> None:
    """Print what a user can mend."""
    errors.print(f"[bold red]Error:[/] {escape(str(error))}")


def report_errors(run: Callable[[], object]) -> None:
    """Run a command; print what a user can mend, and exit with its status."""
    # pygame-ce greets on import unless told not to.
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    with stopped_in_a_line():
        try:
            run()
        except StudyError as error:
            tell(error)
            sys.exit(error.exit_status)
