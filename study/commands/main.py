"""The command line `study`: one thin file a command."""

from __future__ import annotations

import typer

from study.commands import (
    console,
    demo,
    experiment,
    export_foxglove,
    gallery,
    lock,
    participants,
    plan,
    preflight,
    protocol,
    recover,
    replay,
    robots,
    run,
    simulate,
    train_user,
    validate,
    whatif,
)
from study.commands.terminal import report_errors
from study.version_option import VersionOption

app = typer.Typer(
    name="study",
    help="Run and record studies of one person and a fleet of robots.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.callback()
def study(*, version: VersionOption = False) -> None:
    """Run and record studies of one person and a fleet of robots."""


app.command("demo")(demo.demo)
app.command("run")(run.run)
app.command("console")(console.console)
app.command("participants")(participants.participants)
app.command("plan")(plan.plan)
app.command("simulate")(simulate.simulate)
app.command("experiment")(experiment.experiment)
app.command("replay")(replay.replay)
app.command("whatif")(whatif.whatif)
app.command("recover")(recover.recover)
app.command("export-foxglove")(export_foxglove.export_foxglove)
app.command("gallery")(gallery.gallery)
app.command("preflight")(preflight.preflight)
app.command("validate")(validate.validate)
app.command("protocol")(protocol.protocol)
app.command("lock")(lock.lock)
app.command("robot-keys")(robots.robot_keys)
app.command("robot-stop")(robots.robot_stop)
app.command("robot-release")(robots.robot_release)
app.command("robot-twin")(robots.robot_twin)
app.command("train-user")(train_user.train_user)
app.command("check-user")(train_user.check_user)


def main() -> None:
    """Run the command line."""
    report_errors(app)


if __name__ == "__main__":
    main()
