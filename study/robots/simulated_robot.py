"""What a robot of the digital twin has in place of motors and a camera."""

from __future__ import annotations

import time

import numpy as np

from study.arena.cameras import Cameras
from study.arena.model import FRAME_HEIGHT, FRAME_WIDTH
from study.arena.physics import ArenaPhysics, wheel_speeds
from study.robots.link import Frame

FRAME_PERIOD_S = 1 / 15
"""Between two pictures of a camera, seconds."""


class SimulatedMotors:
    """Motors of one robot, uneven as real ones are.

    Args:
        physics: the world.
        robot: its number.
        random: for what is uneven.
        noise: of a wheel's speed, one standard deviation, part of it.
    """

    def __init__(
        self, physics: ArenaPhysics, robot: int, random: np.random.Generator, noise: float
    ) -> None:
        self._physics, self._robot = physics, robot
        self._random, self._noise = random, noise

    def set_velocity(self, linear: float, angular: float) -> None:
        """Drive, m/s and rad/s."""
        left, right = wheel_speeds(linear, angular)
        uneven = 1 + self._noise * np.clip(self._random.standard_normal(2), -3, 3)
        self._physics.set_wheels(self._robot, left * uneven[0], right * uneven[1])


class SimulatedCamera:
    """The front camera of one robot; every picture has the noise of a sensor.

    Args:
        cameras: draws them.
        robot: its number.
        random: for the noise.
        frozen, dead: which robots' cameras are.
    """

    def __init__(
        self,
        cameras: Cameras,
        robot: int,
        random: np.random.Generator,
        frozen: set[int],
        dead: set[int],
    ) -> None:
        self._cameras, self._robot, self._random = cameras, robot, random
        self._frozen, self._dead = frozen, dead
        # Not all at one time: drawing holds up everything else.
        self._next = time.monotonic() + random.uniform(0, FRAME_PERIOD_S)
        self._sequence = 0
        self._pixels = b""

    def frame(self) -> Frame | None:
        """Return a picture if one is due."""
        now = time.monotonic()
        if now < self._next or self._robot in self._dead:
            return None
        self._next = max(self._next + FRAME_PERIOD_S, now)
        self._sequence += 1
        if self._robot not in self._frozen or not self._pixels:
            picture = self._cameras.picture(self._robot)
            noise = self._random.integers(0, 4, picture.shape, np.uint8)
            self._pixels = (np.clip(picture, 2, 253) + noise - 2).astype(np.uint8).tobytes()
        return Frame(self._sequence, time.monotonic_ns(), FRAME_WIDTH, FRAME_HEIGHT, self._pixels)
