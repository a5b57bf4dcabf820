"""Backing out: a robot that is driven forward and does not move has run against something."""

from __future__ import annotations

import math

from study.screens import Tile

MOVES = 0.2
"""Share of a forward step below which a robot counts as not moving."""


class Backing:
    """Notices that the operated robot stands although it is driven forward, and backs it out.

    Args:
        step_m: how far a forward step goes, metres.
        stalled: timesteps without moving after which it backs.
        reversing: timesteps that it backs.
    """

    def __init__(self, step_m: float, stalled: int, reversing: int) -> None:
        self._step_m = step_m
        self._most = stalled
        self._reversing = reversing
        self.begin()

    def begin(self) -> None:
        """Start on another robot, or on the same one's new episode."""
        self._key = ""
        self._place: tuple[float, float] | None = None
        self._stalled = 0
        self._left = 0

    def start(self) -> None:
        """Back from this timestep on, which counts."""
        self._left = self._reversing - 1

    def is_due(self, tile: Tile) -> bool:
        """Return whether to back in this timestep; once a timestep."""
        if self._left > 0:
            self._left -= 1
            return True
        if self._is_stalled(tile):
            self.start()
            return True
        return False

    def note(self, key: str, tile: Tile) -> None:
        """Take note of the key that is pressed, and of where the robot is meanwhile."""
        self._key, self._place = key, (tile.x, tile.y)

    def _is_stalled(self, tile: Tile) -> bool:
        if self._key != "up" or self._place is None:
            self._stalled = 0
            return False
        moved = math.hypot(tile.x - self._place[0], tile.y - self._place[1])
        self._stalled = self._stalled + 1 if moved < MOVES * self._step_m else 0
        if self._stalled < self._most:
            return False
        self._stalled = 0
        return True
