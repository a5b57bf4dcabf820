"""Driving laps: along a course with gates, clear of what stands or drives there.

The course is read off the screen: gates, walls, and where each robot shown is and how it stands.
Before front cameras it goes by the same numbers, as a person knows the arena from having stood
in it; it reads no pictures.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from study.events.scene import DiscMark, Scene
from study.screens import FleetScreen, Tile
from study.simulated.backing import Backing
from study.simulated.parameters import OperatorParameters
from study.simulated.planner import difference

STEP_M = 0.03
TURN_DEG = 10.0
"""What a timestep of `forward` and of a turn does to a robot of this size; learned in practice."""
LOOK_AHEAD_M = 0.4
"""Along the course at which one aims: four robots' radii."""
INWARD = 0.42
"""Where gates are passed, from the inner end to the outer: inside of the middle, to save way."""
SIDE_M = 0.12
"""Kept beside robots' sides: one radius, so that nobody is touched by a turn too late."""
AVOID_M = 0.45
"""How far ahead one looks for what is in the way: four to five radii."""
_PLACES = 240
_FAN = tuple(math.radians(degrees) for degrees in (0, 15, -15, 30, -30, 45, -45, 65, -65, 90, -90))
_STALLED_TIMESTEPS = 6
_REVERSING_TIMESTEPS = 5
_WAIT_TIMESTEPS = 12


def lap_parameters(parameters: OperatorParameters) -> OperatorParameters:
    """Return an operator's parameters with the steps that it has learned of robots that do laps."""
    return parameters.model_copy(update={"forward_step_m": STEP_M, "turn_step_deg": TURN_DEG})


class LapWay:
    """The line that is driven: closed, smooth, through each gate a little inside of its middle.

    Args:
        scene: the map; has three gates at least.

    Attributes:
        period: length of a lap, metres.
        longest: 0: the way never ends.
    """

    longest = 0.0

    def __init__(self, scene: Scene) -> None:
        passed = np.array(
            [
                (
                    gate.inner_x + INWARD * (gate.outer_x - gate.inner_x),
                    gate.inner_y + INWARD * (gate.outer_y - gate.inner_y),
                )
                for gate in scene.gates
            ]
        )
        around = np.vstack([passed, passed[:1]])
        curve = CubicSpline(np.arange(len(around)), around, bc_type="periodic")
        # Positions count from the last gate, the finish line.
        places = curve(len(passed) - 1 + np.linspace(0, len(passed), _PLACES + 1))
        lengths = np.hypot(*np.diff(places, axis=0).T)
        self._x: list[float] = places[:-1, 0].tolist()
        self._y: list[float] = places[:-1, 1].tolist()
        self._at: list[float] = np.concatenate([[0.0], np.cumsum(lengths)[:-1]]).tolist()
        self.period = float(lengths.sum())
        self._line = places[:-1]

    def to_go(self, x: float, y: float, heading: float) -> tuple[float, float]:
        """Return the way to the finish line, metres, and the turn onto the course, radians."""
        nearest = self._nearest(x, y)
        aim_x, aim_y = self.ahead(x, y)
        turn = abs(difference(math.atan2(aim_y - y, aim_x - x), heading))
        return self.period - self._at[nearest], turn

    def ahead(self, x: float, y: float) -> tuple[float, float]:
        """Return the point of the course to aim at from (x, y), metres."""
        step = max(1, round(LOOK_AHEAD_M / self.period * _PLACES))
        place = (self._nearest(x, y) + step) % _PLACES
        return self._x[place], self._y[place]

    def in_hazard(self, x: float, y: float) -> bool:
        """Return False: nothing on a course does harm."""
        del x, y
        return False

    def hazard_ahead(self, x: float, y: float, heading: float, reach: float) -> bool:
        """Return False: nothing on a course does harm."""
        del x, y, heading, reach
        return False

    def _nearest(self, x: float, y: float) -> int:
        return int(np.hypot(self._line[:, 0] - x, self._line[:, 1] - y).argmin())


@functools.lru_cache(maxsize=4)
def lap_way(scene: Scene) -> LapWay:
    """Return the way of a map with gates, built once for each map."""
    return LapWay(scene)


class LapSkill:
    """Reads a course, and drives laps: a `study.simulated.ways.Skill`.

    Of directions near to that of the course it takes the nearest that is free: of walls, of
    buckets, and of the robots that the screen shows. Where none is, it waits a little, then backs.

    Args:
        parameters: of the operator, with the steps learned.
        random: its stream; one number is drawn a timestep.
    """

    def __init__(self, parameters: OperatorParameters, random: np.random.Generator) -> None:
        self._parameters = parameters
        self._random = random
        self._tolerance = math.radians(parameters.turn_step_deg * parameters.heading_tolerance)
        self._way: LapWay | None = None
        self._scene: Scene | None = None
        self._buckets: tuple[DiscMark, ...] = ()
        self._others: tuple[Tile, ...] = ()
        self._backing = Backing(STEP_M, _STALLED_TIMESTEPS, _REVERSING_TIMESTEPS)
        self.begin()

    def begin(self) -> None:
        """Start on another robot, or on the same one's new episode."""
        self._key = ""
        self._backing.begin()
        self._waited = 0

    def read(self, screen: FleetScreen) -> LapWay:
        """Look at the course and at the other robots; return the way round."""
        return self.look(screen.scene, screen.tiles, screen.operated)

    def look(self, scene: Scene, tiles: Sequence[Tile], own: int) -> LapWay:
        """Look at a course and at all robots but ``own``; return the way round."""
        if self._way is None or scene is not self._scene:
            self._scene, self._way = scene, lap_way(scene)
            self._buckets = tuple(mark for mark in scene.discs if mark.role == "wall")
        self._others = tuple(tile for tile in tiles if tile.robot != own)
        return self._way

    def key(self, tile: Tile) -> str:
        """Return the driving key for the next timestep, "" for none; after `read`."""
        wanted = self._wanted(tile)
        if self._key and self._random.random() < self._parameters.steering_lapse:
            wanted = self._key
        self._key = wanted
        self._backing.note(wanted, tile)
        return wanted

    def _wanted(self, tile: Tile) -> str:
        if self._way is None or self._scene is None:
            return ""
        if self._backing.is_due(tile):
            return "down"
        aim_x, aim_y = self._way.ahead(tile.x, tile.y)
        course = math.atan2(aim_y - tile.y, aim_x - tile.x)
        ways = (course + aside for aside in _FAN)
        free = next((way for way in ways if self._is_free(self._scene, tile, way)), None)
        if free is None:
            self._waited += 1
            if self._waited < _WAIT_TIMESTEPS:
                return ""
            self._waited = 0
            self._backing.start()
            return "down"
        self._waited = 0
        turn = difference(free, tile.heading)
        if turn > self._tolerance:
            return "left"
        return "right" if turn < -self._tolerance else "up"

    def _is_free(self, scene: Scene, tile: Tile, direction: float) -> bool:
        """Return whether a robot could go on for a while in a direction.

        What is near already is no hindrance to a way that leads away from it.
        """
        ahead_x, ahead_y = math.cos(direction), math.sin(direction)
        for other in self._others:
            away_x, away_y = other.x - tile.x, other.y - tile.y
            along = away_x * ahead_x + away_y * ahead_y
            aside = abs(away_x * ahead_y - away_y * ahead_x)
            if 0.0 < along < AVOID_M and aside < 2 * scene.robot_radius + SIDE_M / 3:
                return False
        reach, keep = AVOID_M / 2, scene.robot_radius + SIDE_M / 4
        x, y = tile.x + reach * ahead_x, tile.y + reach * ahead_y
        if not (keep < x < scene.width - keep and keep < y < scene.height - keep):
            return False
        for step in (0.5, 1.0):
            x, y = tile.x + step * reach * ahead_x, tile.y + step * reach * ahead_y
            for bucket in self._buckets:
                if math.hypot(bucket.x - x, bucket.y - y) < bucket.radius + keep:
                    return False
        return True
