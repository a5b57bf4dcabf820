"""Where robots are drawn between timesteps: one timestep behind, on the way between two states.

Needs no window, so that it can be tested alone.
"""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Iterable
from itertools import pairwise

from study.screens import FleetScreen, Tile

LONGEST_GAP = 3.0
"""States further apart than this many timesteps are not joined: the run stood still."""
TRAIL_STATES = 12


@dataclasses.dataclass(frozen=True, slots=True)
class Pose:
    """Where a robot is drawn.

    Attributes:
        x, y: metres.
        heading: radians, counter-clockwise from +x.
        trail: places passed, newest first, metres.
    """

    x: float
    y: float
    heading: float
    trail: tuple[tuple[float, float], ...] = ()


def fraction(now_ns: int, t_ns: int, timestep_seconds: float) -> float:
    """Return how much of a timestep has passed since its states came, 0 to 1."""
    if timestep_seconds <= 0:
        return 1.0
    return min(1.0, max(0.0, (now_ns - t_ns) / (timestep_seconds * 1e9)))


def between(before: Tile, after: Tile, share: float) -> Pose:
    """Return the pose at a share of the way; headings turn the shorter way round."""
    turn = math.remainder(after.heading - before.heading, 2 * math.pi)
    return Pose(
        x=before.x + (after.x - before.x) * share,
        y=before.y + (after.y - before.y) * share,
        heading=before.heading + turn * share,
    )


def along_trail(
    places: Iterable[tuple[float, float]], distances: tuple[float, ...]
) -> list[tuple[float, float]]:
    """Return the points at these distances back along a path, as far as the path reaches.

    Args:
        places: the path, newest first; read no further than the last distance.
        distances: ascending, in the unit of the path.
    """
    points: list[tuple[float, float]] = []
    passed, found, wanted = 0.0, 0, len(distances)
    for (x0, y0), (x1, y1) in pairwise(places):
        across, down = x1 - x0, y1 - y0
        length = math.hypot(across, down)
        reached = passed + length
        while found < wanted and length > 0 and reached >= distances[found]:
            share = (distances[found] - passed) / length
            points.append((x0 + across * share, y0 + down * share))
            found += 1
        if found == wanted:
            break
        passed = reached
    return points


class Motion:
    """Remembers the states before the current ones, and where each robot has been."""

    def __init__(self) -> None:
        self._before: dict[int, Tile] = {}
        self._current: FleetScreen | None = None
        self._dwell_before = -1.0
        self._trails: dict[int, deque[tuple[float, float]]] = {}

    def copy(self) -> Motion:
        """Return what goes on from here by itself."""
        twin = Motion()
        twin._before = dict(self._before)
        twin._current, twin._dwell_before = self._current, self._dwell_before
        twin._trails = {robot: trail.copy() for robot, trail in self._trails.items()}
        return twin

    def observe(self, screen: FleetScreen) -> None:
        """Take note of the screen to be drawn; the same states again change nothing."""
        current = self._current
        if current is screen:
            return
        if current is None or not _continues(current, screen):
            self._before = {}
            self._trails = {}
            self._dwell_before = -1.0
        elif current.t_ns != screen.t_ns:
            self._before = {tile.robot: tile for tile in current.tiles}
            self._dwell_before = current.dwell_left
        self._current = screen
        for tile in screen.tiles:
            before = self._before.get(tile.robot)
            trail = self._trails.setdefault(tile.robot, deque(maxlen=TRAIL_STATES))
            if before is None or before.episode != tile.episode:
                self._before.pop(tile.robot, None)
                if not trail or trail[0] != (tile.x, tile.y):
                    trail.clear()
            if not trail or trail[0] != (tile.x, tile.y):
                trail.appendleft((tile.x, tile.y))
        for robot in set(self._trails) - {tile.robot for tile in screen.tiles}:
            del self._trails[robot]

    def pose(self, screen: FleetScreen, tile: Tile, now_ns: int) -> Pose:
        """Return where a robot of the observed screen is drawn."""
        before = self._before.get(tile.robot)
        trail = tuple(self._trails.get(tile.robot, ()))
        if before is None:
            return Pose(tile.x, tile.y, tile.heading, trail)
        share = fraction(now_ns, screen.t_ns, screen.timestep_seconds)
        drawn = between(before, tile, share)
        # The robot is not yet where its newest state is.
        here = (tile.x, tile.y)
        passed = trail[1:] if trail[:1] == (here,) else trail
        if here in passed:
            passed = tuple(place for place in passed if place != here)
        return Pose(drawn.x, drawn.y, drawn.heading, ((drawn.x, drawn.y), *passed))

    def dwell_left(self, screen: FleetScreen, now_ns: int) -> float:
        """Return the share of the dwell left, drawn smoothly; -1 if there is none."""
        if screen.dwell_left < 0 or self._dwell_before < screen.dwell_left:
            return screen.dwell_left
        share = fraction(now_ns, screen.t_ns, screen.timestep_seconds)
        return self._dwell_before + (screen.dwell_left - self._dwell_before) * share


def _continues(before: FleetScreen, after: FleetScreen) -> bool:
    """Return whether one screen follows another in the same fleet run."""
    longest = LONGEST_GAP * max(after.timestep_seconds, 1e-3) * 1e9
    return (
        before.robots == after.robots
        and before.trial == after.trial
        and before.heading == after.heading
        and 0 <= after.timestep - before.timestep <= LONGEST_GAP
        and 0 <= after.t_ns - before.t_ns <= longest
    )
