"""Where the command line begins: Ctrl-C is no traceback even while the rest is being imported."""

from __future__ import annotations

import sys


def main() -> None:
    """Import the commands and run one."""
    try:
        from study.commands.main import main as run  # noqa: PLC0415 - what may be interrupted
    except KeyboardInterrupt:
        sys.stderr.write("Stopped.\n")
        sys.exit(130)
    run()
