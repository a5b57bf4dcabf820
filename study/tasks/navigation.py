"""Driving through linked rooms: past hazards, by way of health packs, to a goal.

Robots do not influence each other. An episode's start and all its motion noise come from
the robot's seed at reset, so a robot's future depends on its own seed and actions alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, model_validator

from study.events.codes import Outcome
from study.events.task_description import RewardTerm, StateField, TaskDescription
from study.layouts import named_layout
from study.tasks.base import FleetStep, Floats, Ints, Mask, Seeds
from study.terrain import Terrain

OUT_OF_PROCESS = False
"""A step takes microseconds: it needs no process of its own."""

ACTIONS = ("forward", "backward", "turn left", "turn right", "idle")
FORWARD, BACKWARD, TURN_LEFT, TURN_RIGHT, IDLE = range(5)
FULL_HEALTH = 100.0

_RUNNING, _GOAL, _LOST, _TIME_UP = map(
    int, (Outcome.RUNNING, Outcome.GOAL, Outcome.LOST, Outcome.TIME_UP)
)
_NOISE_LIMIT = 3.0
"""Noise is cut off at this many standard deviations, so that no robot jumps a wall."""
_HALF_TURN = float(np.nextafter(np.float32(np.pi), np.float32(0)))
"""The largest float32 below pi: float32(pi) itself lies above it."""


class Rewards(BaseModel):
    """Points, added up over robots and timesteps."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    progress: float = Field(1.0, description="points per metre of driving distance to the goal")
    health: float = Field(0.1, description="points per health point gained or lost")
    goal: float = Field(10.0, description="points when a robot reaches the goal")
    lost: float = Field(-10.0, description="points when a robot's health reaches 0")
    timestep: float = Field(-0.05, description="points for each timestep of each running robot")


class Parameters(BaseModel):
    """What a protocol can set of the task."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    layout: str = Field("three_rooms", description="name of the map")
    horizon: int = Field(200, ge=1, le=100_000, description="longest episode, timesteps")
    forward: float = Field(0.5, gt=0, description="way of one step forward, metres")
    back: float = Field(0.3, gt=0, description="way of one step backward, metres")
    turn: float = Field(15.0, gt=0, lt=180, description="angle of one turn, degrees")
    noise: float = Field(
        0.03,
        ge=0,
        description="standard deviation of a step's error: metres in x and in y when driving, "
        "radians in heading when driving or turning; cut off at 3 standard deviations",
    )
    hazard_damage: float = Field(5.0, ge=0, description="health lost per timestep in a hazard")
    pack_heal: float = Field(10.0, ge=0, description="health gained per timestep on a pack")
    start_health: tuple[float, float] = Field(
        (60.0, 100.0), description="range of the health at the start, points"
    )
    rewards: Rewards = Field(Rewards(), description="points")

    @model_validator(mode="after")
    def _check(self) -> Parameters:
        low, high = self.start_health
        if not 0 < low <= high <= FULL_HEALTH:
            raise ValueError(f"start_health is {[low, high]}; it must rise within 0 to 100")
        longest = max(self.forward, self.back) + math.sqrt(2) * _NOISE_LIMIT * self.noise
        wall = 2 * named_layout(self.layout).robot_radius
        if longest >= wall:
            raise ValueError(
                f"a step of up to {longest:.2f} m (forward or back with noise) could jump a wall; "
                f"it must stay under {wall:.2f} m"
            )
        return self


def describe(parameters: Mapping[str, object] | Parameters) -> TaskDescription:
    """Return the task's description.

    Args:
        parameters: as in a protocol; omitted ones have their defaults.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    settings = Parameters.model_validate(parameters)
    layout = named_layout(settings.layout)
    points = settings.rewards
    return TaskDescription(
        name="navigation",
        version=1,
        state_fields=(
            StateField("x", "m", 0.0, layout.width),
            StateField("y", "m", 0.0, layout.height),
            StateField("heading", "rad", -math.pi, math.pi, circular=True),
            StateField("health", "points", 0.0, FULL_HEALTH),
        ),
        x_field=0,
        y_field=1,
        heading_field=2,
        health_field=3,
        action_names=ACTIONS,
        idle_action=IDLE,
        key_actions={"up": FORWARD, "down": BACKWARD, "left": TURN_LEFT, "right": TURN_RIGHT},
        horizon=settings.horizon,
        rewards=(
            RewardTerm("progress", points.progress, "each metre", "closer to the goal"),
            RewardTerm("goal", points.goal, "robot reaches", "the goal"),
            RewardTerm("health", points.health, "each health point", "gained or lost"),
            RewardTerm("lost", points.lost, "robot lost", "(health 0)"),
            RewardTerm("timestep", points.timestep, "each step", ""),
        ),
        scene=layout.scene(),
        map_grid=layout.map_grid(
            cell=0.5,
            headings=(0.0, math.pi / 2, math.pi, -math.pi / 2),
            healths=(25.0, 50.0, 75.0, 100.0),
        ),
        resimulable="exact",
    )


def create(robots: int, parameters: Mapping[str, object] | Parameters) -> NavigationTask:
    """Make a fleet; every robot awaits its first reset.

    Args:
        robots: number of robots, n.
        parameters: as in a protocol; omitted ones have their defaults.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    return NavigationTask(robots, Parameters.model_validate(parameters))


class NavigationTask:
    """A fleet of robots in a map of rooms; a `study.tasks.base.SnapshotTask`.

    States are [x, y, heading, health]: metres, metres, radians in [-pi, pi), points. They
    are kept as float32 and computed with in float64, so that the observation is the whole
    of what a robot's dynamics depend on besides its timestep and its noise.

    Args:
        robots: number of robots, n.
        parameters: dynamics and rewards.
    """

    def __init__(self, robots: int, parameters: Parameters) -> None:
        self.description = describe(parameters)
        self.robots = robots
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
        self._rows = np.arange(robots)
        self._states = np.zeros((robots, 4), np.float32)
        # A robot that was never reset counts as ended.
        self._outcomes = np.full(robots, Outcome.TIME_UP, np.int32)
        self._timesteps = np.zeros(robots, np.int32)
        self._distances = np.zeros(robots)
        self._noise = np.zeros((robots, parameters.horizon, 3))

    def reset(self, mask: Mask, seeds: Seeds) -> Floats:
        """Start new episodes for the robots in ``mask`` [n]; ``seeds`` uint64 [n].

        Returns:
            States of all robots, float32 [n, 4].
        """
        for robot in np.flatnonzero(mask):
            random = np.random.Generator(np.random.PCG64(np.random.SeedSequence(int(seeds[robot]))))
            self._states[robot] = self._start_state(random)
            noise = random.standard_normal((self.parameters.horizon, 3))
            self._noise[robot] = np.clip(noise, -_NOISE_LIMIT, _NOISE_LIMIT)
            self._outcomes[robot] = Outcome.RUNNING
            self._timesteps[robot] = 0
        x, y = self._states.astype(np.float64).T[:2]
        np.copyto(self._distances, self.terrain.goal_distance(x, y), where=mask)
        return self._states.copy()

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Step the robots in ``active`` [n] that have not ended by ``actions`` int32 [n].

        A robot that cannot make its whole way slides: it goes as far in x, else in y, as it
        wanted to, else it stays. Then hazard and pack act, then the outcome is decided:
        lost before goal before time up.

        Raises:
            ValueError: an active robot's action is none of `ACTIONS`.
        """
        stepped = active & (self._outcomes == _RUNNING)
        actions = np.where(stepped, actions, IDLE)
        if (actions.astype(np.uint32) >= len(ACTIONS)).any():
            raise ValueError(f"actions must be 0 to {len(ACTIONS) - 1}: {actions.tolist()}")
        before = self._states.astype(np.float64).T
        after = self._moved(before, actions).astype(np.float32)
        x, y, _, health = after.astype(np.float64)

        points, terrain = self.parameters.rewards, self.terrain
        lost, at_goal = health <= 0, terrain.at_goal(x, y)
        outcomes = (self._timesteps + 1 >= self.parameters.horizon) * _TIME_UP
        outcomes[at_goal] = _GOAL
        outcomes[lost] = _LOST
        distances = terrain.goal_distance(x, y)
        rewards = points.progress * (self._distances - distances) + points.timestep
        rewards += points.health * (health - before[3])
        rewards += points.lost * lost + points.goal * (at_goal & ~lost)

        np.copyto(self._states, after.T, where=stepped[:, None])
        np.copyto(self._outcomes, outcomes, where=stepped, casting="same_kind")
        np.copyto(self._distances, distances, where=stepped)
        self._timesteps += stepped
        return FleetStep(
            states=self._states.copy(),
            rewards=np.where(stepped, rewards, 0.0).astype(np.float32),
            outcomes=self._outcomes.copy(),
        )

    def snapshot(self) -> dict[str, npt.NDArray[Any]]:
        """Return copies of all arrays that determine the future, noise included."""
        return {name: array.copy() for name, array in self._memory().items()}

    def restore(self, snapshot: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put back what `snapshot` returned."""
        for name, array in self._memory().items():
            array[...] = snapshot[name]

    def close(self) -> None:
        """Do nothing: the task holds memory only."""

    def _memory(self) -> dict[str, npt.NDArray[Any]]:
        return {
            "states": self._states,
            "outcomes": self._outcomes,
            "timesteps": self._timesteps,
            "distances": self._distances,
            "noise": self._noise,
        }

    def _start_state(self, random: np.random.Generator) -> Floats:
        """Draw a place in the start region's free part, a heading and a health."""
        start, terrain = self.terrain.layout.start, self.terrain
        while True:
            place = random.uniform((start.left, start.bottom), (start.right, start.top))
            x, y = place.astype(np.float32).astype(np.float64)[:, None]
            if terrain.is_legal(x, y)[0] and not terrain.in_hazard(x, y)[0]:
                break
        heading = np.clip(random.uniform(-np.pi, np.pi), -_HALF_TURN, _HALF_TURN)
        health = random.uniform(*self.parameters.start_health)
        return np.array([x[0], y[0], heading, health], np.float32)

    def _moved(self, before: npt.NDArray[np.float64], actions: Ints) -> npt.NDArray[np.float64]:
        """Return the states [4, n] after moving and after hazard and pack have acted."""
        x, y, heading, health = before
        at = np.minimum(self._timesteps, self.parameters.horizon - 1)
        travel, turn, *scale = self._effects[actions].T
        noise = self._noise[self._rows, at].T * scale
        # Places are rounded before they are checked: what is kept is what was found legal.
        wanted_x = (x + travel * np.cos(heading) + noise[0]).astype(np.float32)
        wanted_y = (y + travel * np.sin(heading) + noise[1]).astype(np.float32)
        try_x = np.array([wanted_x, wanted_x, x, x])
        try_y = np.array([wanted_y, y, wanted_y, y])
        legal = self.terrain.is_legal(try_x, try_y)
        legal[3] = True
        first = legal.argmax(axis=0)
        x, y = try_x[first, self._rows], try_y[first, self._rows]

        heading = (heading + turn + noise[2] + np.pi) % (2 * np.pi) - np.pi
        heading = np.minimum(np.maximum(heading, -_HALF_TURN), _HALF_TURN)
        health = health - self.parameters.hazard_damage * self.terrain.in_hazard(x, y)
        health += self.parameters.pack_heal * self.terrain.at_pack(x, y)
        return np.array([x, y, heading, np.minimum(np.maximum(health, 0.0), FULL_HEALTH)])
