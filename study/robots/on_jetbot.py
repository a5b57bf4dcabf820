"""The agent's program on a JetBot, with NVIDIA's library ``jetbot`` for motors and camera.

    python -m study.robots.on_jetbot robot1.toml --operator public_keys.toml --full-speed 0.5

It needs Python 3.11 and pyzmq beside that library. ``--full-speed`` is how fast a wheel runs at
full power, in metres a second: drive straight on for a few seconds and measure. Tests run it with
a library of our own in NVIDIA's place.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from study.arena.model import FRAME_HEIGHT, FRAME_WIDTH, TRACK
from study.errors import StudyError
from study.robots.agent import Agent
from study.robots.keys import OPERATOR, read_pair, read_public
from study.robots.link import MAX_ANGULAR, MAX_LINEAR, Frame
from study.robots.watchdog import Limits, Watchdog

FRAME_PERIOD_S = 1 / 15


class WheelMotors:
    """Motors that take the power of each wheel.

    Args:
        set_powers: takes left and right, -1 to 1.
        full_speed: of a wheel at power 1, m/s.
    """

    def __init__(self, set_powers: Callable[[float, float], None], full_speed: float) -> None:
        self._set_powers = set_powers
        self._full_speed = full_speed

    def set_velocity(self, linear: float, angular: float) -> None:
        """Drive, m/s and rad/s; what is too fast for a wheel slows both: the curve stays."""
        across = angular * TRACK / 2
        left, right = (linear - across) / self._full_speed, (linear + across) / self._full_speed
        most = max(1.0, abs(left), abs(right))
        self._set_powers(left / most, right / most)


class ArrayCamera:
    """Frames from a camera that keeps its newest picture: rows of blue, green, red.

    Args:
        newest: returns it; a new object for each picture.
        clock: seconds, monotonic.
    """

    def __init__(
        self, newest: Callable[[], Any], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._newest = newest
        self._clock = clock
        self._next = 0.0
        self._last: Any = None
        self._sequence = 0

    def frame(self) -> Frame | None:
        """Return a picture if one is due and the camera has a new one."""
        now = self._clock()
        picture = self._newest()
        if now < self._next or picture is None or picture is self._last:
            return None
        self._next, self._last = now + FRAME_PERIOD_S, picture
        self._sequence += 1
        height, width = picture.shape[:2]
        pixels: bytes = picture[..., ::-1].tobytes()
        return Frame(self._sequence, time.monotonic_ns(), width, height, pixels)


def main(arguments: list[str] | None = None, goes_on: Callable[[], bool] = lambda: True) -> None:
    """Run the agent until told otherwise."""
    parser = argparse.ArgumentParser(description="Let an operator drive this JetBot.")
    parser.add_argument("key", type=Path, help="this robot's private key file")
    parser.add_argument("--operator", type=Path, required=True, help="file of public keys")
    parser.add_argument("--port", type=int, default=5555)
    parser.add_argument("--full-speed", type=float, required=True, help="of a wheel, m/s")
    parser.add_argument("--max-linear", type=float, default=0.3, help="m/s")
    parser.add_argument("--max-angular", type=float, default=2.0, help="rad/s")
    given = parser.parse_args(arguments)
    if not (0 < given.max_linear <= MAX_LINEAR and 0 < given.max_angular <= MAX_ANGULAR):
        sys.exit(f"Limits are up to {MAX_LINEAR} m/s and {MAX_ANGULAR} rad/s.")
    try:
        library: Any = importlib.import_module("jetbot")
    except ImportError:
        sys.exit("NVIDIA's library jetbot is not installed: this program runs on the robot.")
    robot = library.Robot()
    camera = library.Camera.instance(width=FRAME_WIDTH, height=FRAME_HEIGHT)
    try:
        agent = Agent(
            Watchdog(
                WheelMotors(robot.set_motors, given.full_speed),
                # NVIDIA's library does not know the battery; its own display does.
                lambda: 1.0,
                Limits(given.max_linear, given.max_angular),
            ),
            ArrayCamera(lambda: camera.value),
            keys=read_pair(given.key),
            operators=frozenset({read_public(given.operator)[OPERATOR]}),
            address=f"tcp://*:{given.port}" if given.port else "tcp://127.0.0.1:*",
        )
    except StudyError as error:
        sys.exit(str(error))
    print(f"Listening at {agent.address}", flush=True)  # noqa: T201 - a program's answer
    agent.run(goes_on)


if __name__ == "__main__":
    main()
