"""An agent in a thread whose motors note when they were told what; no simulation."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from study.robots.agent import Agent
from study.robots.keys import OPERATOR, make_keys, read_pair, read_public
from study.robots.link import Frame
from study.robots.watchdog import Limits, Watchdog


class NotedMotors:
    """Keeps each velocity that differs from the last, with its time."""

    def __init__(self) -> None:
        self.notes: list[tuple[float, float, float]] = []

    def set_velocity(self, linear: float, angular: float) -> None:
        """Note it."""
        if not self.notes or self.notes[-1][1:] != (linear, angular):
            self.notes.append((time.monotonic(), linear, angular))

    @property
    def now(self) -> tuple[float, float]:
        """What they are told now."""
        return self.notes[-1][1:]

    @property
    def since(self) -> float:
        """Since when."""
        return self.notes[-1][0]


class SmallCamera:
    """Takes pictures of two by one pixels, 50 a second, that differ unless it is frozen."""

    def __init__(self) -> None:
        self.frozen = False
        self._sequence = 0
        self._at = 0.0
        self._pixels = bytes(6)

    def frame(self) -> Frame | None:
        """Return a picture if one is due."""
        now = time.monotonic()
        if now - self._at < 0.02:
            return None
        self._at = now
        self._sequence += 1
        if not self.frozen:
            self._pixels = bytes(self._sequence >> shift & 255 for shift in (0, 8, 16, 0, 8, 16))
        return Frame(self._sequence, time.monotonic_ns(), 2, 1, self._pixels)


class RunningAgent:
    """One robot without a body.

    Attributes:
        motors, camera, battery: its parts.
        address, public_key: where and who it is.
    """

    def __init__(self, keys: Path, address: str = "tcp://127.0.0.1:*") -> None:
        self.motors, self.camera, self.battery = NotedMotors(), SmallCamera(), 1.0
        self.public_key = read_public(keys / "public_keys.toml")["robot1"]
        self._ending = threading.Event()
        self.agent = Agent(
            Watchdog(self.motors, lambda: self.battery, Limits(0.3, 2.0)),
            self.camera,
            keys=read_pair(keys / "robot1.toml"),
            operators=frozenset({read_pair(keys / f"{OPERATOR}.toml").public}),
            address=address,
        )
        self.address = self.agent.address
        self._thread = threading.Thread(
            target=self.agent.run, args=(lambda: not self._ending.is_set(),)
        )
        self._thread.start()

    def close(self) -> None:
        """End it."""
        self._ending.set()
        self._thread.join()


@contextmanager
def running_agent(folder: Path) -> Iterator[RunningAgent]:
    """Make keys in ``folder``, run an agent, end it."""
    make_keys(folder, [OPERATOR, "robot1"])
    agent = RunningAgent(folder)
    try:
        yield agent
    finally:
        agent.close()
