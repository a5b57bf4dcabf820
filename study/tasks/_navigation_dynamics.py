"""What one timestep does to robots in the rooms, given their actions and noise."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from study.layouts import named_layout
from study.tasks._navigation_parameters import FULL_HEALTH, Parameters
from study.tasks.base import Floats, Ints, Mask
from study.terrain import Terrain

ACTIONS = ("forward", "backward", "turn left", "turn right", "idle")
FORWARD, BACKWARD, TURN_LEFT, TURN_RIGHT, IDLE = range(5)
_HALF_TURN = float(np.nextafter(np.float32(np.pi), np.float32(0)))
"""The largest float32 below pi: float32(pi) itself lies above it."""

Exact = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Transition:
    """What became of n robots in one timestep.

    Attributes:
        states: float32 [n, 4].
        rewards: float64 [n], points.
        lost: bool [n], whether health reached 0.
        at_goal: bool [n], whether the robot is in the goal; one that is lost as well counts
            as lost.
        distances: float64 [n], driving distance to the goal after the step, metres.
    """

    states: Floats
    rewards: Exact
    lost: Mask
    at_goal: Mask
    distances: Exact


def wrapped(heading: Exact) -> Exact:
    """Return headings, float64, in [-pi, pi) as float32 has it."""
    heading = (heading + np.pi) % (2 * np.pi) - np.pi
    return np.minimum(np.maximum(heading, -_HALF_TURN), _HALF_TURN)


class Dynamics:
    """One timestep as a function of states, actions and noise; it remembers nothing.

    States are [x, y, heading, health]: metres, metres, radians in [-pi, pi), points. They
    are kept as float32 and computed with in float64, so that the observation is the whole
    of what a robot's dynamics depend on besides its noise.

    Args:
        parameters: dynamics and rewards.
    """

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters
        self.terrain = Terrain(named_layout(parameters.layout))
        turn, noise = math.radians(parameters.turn), parameters.noise
        # By action: way forwards, turn, and the scale of the noise in x, y and heading.
        self._effects = np.array(
            [
                [parameters.forward, 0.0, noise, noise, noise],
                [-parameters.back, 0.0, noise, noise, noise],
                [0.0, turn, 0.0, 0.0, noise],
                [0.0, -turn, 0.0, 0.0, noise],
                [0.0, 0.0, 0.0, 0.0, 0.0],
            ]
        )

    def transition(
        self, states: Floats, actions: Ints, noise: Exact, distances: Exact | None = None
    ) -> Transition:
        """Step n robots that have not ended.

        A robot that cannot make its whole way slides: it goes as far in x, else in y, as it
        wanted to, else it stays. Then hazard and pack act.

        Args:
            states: float32 [n, 4].
            actions: int [n], each one of `ACTIONS`.
            noise: float64 [n, 3], errors in x, y and heading in standard deviations.
            distances: float64 [n], driving distances to the goal before, where they are known.
        """
        after = self._moved(states.astype(np.float64).T, actions, noise).astype(np.float32)
        return self.judged(states, after.T, distances)

    def judged(self, states: Floats, after: Floats, distances: Exact | None = None) -> Transition:
        """Say what it is worth that n robots came from ``states`` to ``after``, however they did.

        Args:
            states: float32 [n, 4], before the timestep.
            after: float32 [n, 4], after it.
            distances: float64 [n], driving distances to the goal before, where they are known.
        """
        points, terrain = self.parameters.rewards, self.terrain
        before = states.astype(np.float64).T
        if distances is None:
            distances = terrain.goal_distance(before[0], before[1])
        x, y, _, health = after.T.astype(np.float64)
        lost, at_goal = health <= 0, terrain.at_goal(x, y)
        left = terrain.goal_distance(x, y)
        rewards = points.progress * (distances - left) + points.timestep
        rewards += points.health * (health - before[3])
        rewards += points.lost * lost + points.goal * (at_goal & ~lost)
        return Transition(after, rewards, lost, at_goal, left)

    def start_state(self, random: np.random.Generator) -> Floats:
        """Draw a place in the start region's free part, a heading and a health; float32 [4]."""
        start, terrain = self.terrain.layout.start, self.terrain
        while True:
            place = random.uniform((start.left, start.bottom), (start.right, start.top))
            x, y = place.astype(np.float32).astype(np.float64)[:, None]
            if terrain.is_legal(x, y)[0] and not terrain.in_hazard(x, y)[0]:
                break
        heading = np.clip(random.uniform(-np.pi, np.pi), -_HALF_TURN, _HALF_TURN)
        health = random.uniform(*self.parameters.start_health)
        return np.array([x[0], y[0], heading, health], np.float32)

    def spread_states(self, random: np.random.Generator, count: int) -> Floats:
        """Draw states that a running robot can be in: anywhere but in the goal.

        Places are uniform over the floor, headings over the circle, healths over (0, full].

        Args:
            random: the stream to draw from.
            count: how many.

        Returns:
            float32 [count, 4].
        """
        layout = self.terrain.layout
        found = np.zeros((0, 4), np.float32)
        while len(found) < count:
            low = (0.0, 0.0, -np.pi, 0.0)
            high = (layout.width, layout.height, np.pi, FULL_HEALTH)
            drawn = random.uniform(low, high, (2 * count + 16, 4))
            drawn[:, 2] = np.clip(drawn[:, 2], -_HALF_TURN, _HALF_TURN)
            drawn[:, 3] = FULL_HEALTH - drawn[:, 3]
            states = drawn.astype(np.float32)
            x, y = states[:, 0].astype(np.float64), states[:, 1].astype(np.float64)
            fit = self.terrain.is_legal(x, y) & ~self.terrain.at_goal(x, y) & (states[:, 3] > 0)
            found = np.concatenate([found, states[fit]])
        return found[:count]

    def _moved(self, before: Exact, actions: Ints, noise: Exact) -> Exact:
        """Return the states [4, n] after moving and after hazard and pack have acted."""
        x, y, heading, health = before
        travel, turn, *scale = self._effects[actions].T
        error = noise.T * scale
        # Places are rounded before they are checked: what is kept is what was found legal.
        wanted_x = (x + travel * np.cos(heading) + error[0]).astype(np.float32)
        wanted_y = (y + travel * np.sin(heading) + error[1]).astype(np.float32)
        x, y = self._slid(x, y, wanted_x.astype(np.float64), wanted_y.astype(np.float64))

        heading = wrapped(heading + turn + error[2])
        health = health - self.parameters.hazard_damage * self.terrain.in_hazard(x, y)
        health += self.parameters.pack_heal * self.terrain.at_pack(x, y)
        return np.array([x, y, heading, np.minimum(np.maximum(health, 0.0), FULL_HEALTH)])

    def _slid(self, x: Exact, y: Exact, wanted_x: Exact, wanted_y: Exact) -> tuple[Exact, Exact]:
        """Return where robots at x, y [n] come that want to be elsewhere; `wanted_*` change."""
        blocked = (~self.terrain.is_legal(wanted_x, wanted_y)).nonzero()[0]
        if len(blocked):
            try_x = np.array([wanted_x[blocked], x[blocked], x[blocked]])
            try_y = np.array([y[blocked], wanted_y[blocked], y[blocked]])
            legal = self.terrain.is_legal(try_x[:2], try_y[:2])
            first = np.where(legal[0], 0, np.where(legal[1], 1, 2))
            columns = np.arange(len(blocked))
            wanted_x[blocked] = try_x[first, columns]
            wanted_y[blocked] = try_y[first, columns]
        return wanted_x, wanted_y
