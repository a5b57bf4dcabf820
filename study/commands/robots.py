"""`study robot-keys` and `study robot-twin`: who may drive, and robots without robots."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.terminal import console
from study.errors import StudyError

MOST_ROBOTS = 12


def robot_keys(
    folder: Annotated[Path, typer.Argument(help="Folder for the keys; made for you alone.")],
    robots: Annotated[int, typer.Option(min=1, max=MOST_ROBOTS, help="Number of robots.")] = 3,
) -> None:
    """Make the keys of operator, robots and simulated motion capture.

    A robot gets its own file, the operator's computer the operator's; all get the public keys.
    Whoever has no key that the robots know cannot drive them, nor see what they see.
    """
    from study.robots.keys import OPERATOR, make_keys  # noqa: PLC0415 - an extra

    names = [OPERATOR, "motion_capture", *(f"robot{robot + 1}" for robot in range(robots))]
    for path in make_keys(folder, names):
        console.print(escape(str(path)), soft_wrap=True)


def robot_twin(
    keys: Annotated[Path, typer.Argument(help="Folder that study robot-keys made.")],
    robots: Annotated[int, typer.Option(min=1, max=MOST_ROBOTS, help="Number of robots.")] = 3,
    port: Annotated[
        int,
        typer.Option(
            min=0, max=65_000, help="Port of the first robot, the next follow; 0 for free ones."
        ),
    ] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the motors' noise.")] = 0,
    speed: Annotated[
        float, typer.Option(min=0.1, max=20, help="Simulated seconds a second.")
    ] = 1.0,
    write: Annotated[
        Path | None, typer.Option(help="File to write that lists the robots, for a protocol.")
    ] = None,
    *,
    cameras: Annotated[bool, typer.Option("--cameras/--no-cameras", help="Take pictures.")] = True,
) -> None:
    """Serve simulated JetBots on this computer that speak as real ones do, until input ends.

    The first line says where they are, as JSON. Lines of input make faults, for rehearsals:
    camera_frozen ROBOT on|off, camera_dead ROBOT on|off, pose_lost ROBOT on|off,
    battery ROBOT LEVEL, put ROBOT X Y HEADING, quit. Robots count from 1, as on the screen.
    """
    from study.robots.twin import TwinSettings, serve  # noqa: PLC0415 - an extra

    settings = TwinSettings(robots, keys, seed=seed, speed=speed, port=port, cameras=cameras)
    serve(settings, write)


RobotsFile = Annotated[Path, typer.Argument(help="File that lists the robots.")]


def robot_stop(robots_file: RobotsFile) -> None:
    """Stop all robots of a file at once, whoever drives them; they stay stopped until released."""
    _tell(robots_file, stopped=True)
    release = f"study robot-release {robots_file}"
    console.print(f"All robots are stopped. Release them with: {escape(release)}", soft_wrap=True)


def robot_release(robots_file: RobotsFile) -> None:
    """End an emergency stop, once the floor is clear; robots stand until they are driven."""
    _tell(robots_file, stopped=False)
    console.print("All robots may be driven.")


def _tell(robots_file: Path, *, stopped: bool) -> None:
    from study.robots.emergency import EmergencyButton  # noqa: PLC0415 - an extra

    with EmergencyButton.of_file(robots_file) as button:
        missing = button.without_answer(stopped=stopped)
    if missing and stopped:
        raise StudyError(
            f"not known to be stopped, as they do not answer: {', '.join(missing)}",
            "Switch them off. If one moves on, somebody else drives it, or the operator's key in "
            f"{robots_file} is not the one that it knows.",
        )
    if missing:
        raise StudyError(
            f"no answer from {', '.join(missing)}",
            "Check that it is switched on, its agent runs, and the operator's key is right.",
        )
