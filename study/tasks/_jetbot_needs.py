"""What the task jetbot needs outside of its own memory: an extra, robots, a way to stop them."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from study.arena.physics import load_mujoco
from study.tasks._jetbot_parameters import Parameters

if TYPE_CHECKING:
    from study.robots.emergency import EmergencyButton


def open_emergency(parameters: Mapping[str, object] | Parameters) -> EmergencyButton | None:
    """Return what stops the robots behind a link, whoever drives them; None without a link.

    Raises:
        StudyError: the robots' file or a key is missing or wrong.
    """
    settings = Parameters.model_validate(parameters)
    if not settings.link:
        return None
    from study.robots.emergency import EmergencyButton  # noqa: PLC0415 - sockets

    return EmergencyButton.of_file(Path(settings.link))


def missing_extra(parameters: Mapping[str, object] | Parameters) -> str:
    """Return what is to be there before a protocol can run here; empty if it is all there."""
    link = Parameters.model_validate(parameters).link
    needed = ("zmq",) if link else ("mujoco",)
    missing = [name for name in needed if importlib.util.find_spec(name) is None]
    if missing:
        return (
            f"The package {missing[0]} is not installed here; in a clone `make jetbot` installs "
            "it, elsewhere pip install 'scaled-autonomy[jetbot]'."
        )
    if link and not Path(link).is_file():
        return (
            f"{link}, which lists the robots, is not in this folder: write it as "
            "docs/how-to/drive-robots.md says, or have `study robot-twin --write` make one."
        )
    return ""


def check_live(parameters: Mapping[str, object] | Parameters) -> None:
    """See that what is to be driven is there: the physics, or the robots behind a link.

    Of each of those, of its camera and its pose it is seen that they live; then they are let go.

    Raises:
        StudyError: the extra is not installed, or a robot is not live; the message says which.
    """
    settings = Parameters.model_validate(parameters)
    if not settings.link:
        load_mujoco()
    else:
        from study.robots.robots_file import open_fleet  # noqa: PLC0415 - threads, sockets

        fleet = open_fleet(Path(settings.link))
        fleet.connect()
        fleet.disconnect()
