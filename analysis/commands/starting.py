"""Where the command line begins: nothing slow is imported before Ctrl-C is provided for."""

from __future__ import annotations

from study.starting import start


def main() -> None:
    """Import the commands and run one."""
    start("analysis.commands.main")
