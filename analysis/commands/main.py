"""The command `analysis`: reports and tables from recordings."""

from __future__ import annotations

import sys

import typer
from rich.console import Console

from analysis.commands import export, report, tables
from study.errors import StudyError
from study.starting import stopped_in_a_line
from study.version_option import VersionOption

app = typer.Typer(
    name="analysis",
    help="Reports, tables and exports, from recordings alone.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.callback()
def analysis(*, version: VersionOption = False) -> None:
    """Reports, tables and exports, from recordings alone."""


app.command("report")(report.report)
app.command("tables")(tables.tables)
app.command("export")(export.export)


def main() -> None:
    """Run the command line; what a user can mend is one message and exit code 2."""
    with stopped_in_a_line():
        try:
            app()
        except StudyError as error:
            console = Console(stderr=True, soft_wrap=True)
            console.print("[bold red]Error:[/] ", end="")
            console.print(error.message, markup=False, highlight=False)
            if error.hint:
                console.print(error.hint, markup=False, highlight=False)
            sys.exit(2)
