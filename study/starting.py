"""Where both command lines begin: Ctrl-C is one line, and no traceback, at any moment."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager

INTERRUPTED = 130
"""Exit status of a command that Ctrl-C stopped."""


def start(module: str) -> None:
    """Import the module of a command line, which takes a while, and run its ``main``."""
    with stopped_in_a_line():
        run = importlib.import_module(module).main
    run()


@contextmanager
def stopped_in_a_line() -> Iterator[None]:
    """Say of what Ctrl-C stops that it stopped, and exit with its status."""
    try:
        yield
    except KeyboardInterrupt:
        sys.stderr.write("Stopped.\n")
        sys.exit(INTERRUPTED)
    except SystemExit as left:
        # Typer makes this of Ctrl-C, and says nothing.
        if left.code == INTERRUPTED:
            sys.stderr.write("Stopped.\n")
        raise
