"""Driving through linked rooms: past hazards, by way of health packs, to a goal.

Robots do not influence each other. An episode's start and all its motion noise come from
the robot's seed at reset, so a robot's future depends on its own seed and actions alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.events.task_description import TaskDescription
from study.tasks._navigation_description import described
from study.tasks._navigation_dynamics import (
    ACTIONS,
    BACKWARD,
    FORWARD,
    IDLE,
    TURN_LEFT,
    TURN_RIGHT,
    Dynamics,
)
from study.tasks._navigation_parameters import FULL_HEALTH, NOISE_LIMIT, Parameters
from study.tasks.base import FleetStep, Floats, Ints, Mask, Seeds

__all__ = [
    "ACTIONS",
    "BACKWARD",
    "FORWARD",
    "IDLE",
    "OUT_OF_PROCESS",
    "TURN_LEFT",
    "TURN_RIGHT",
    "NavigationTask",
    "Parameters",
    "create",
    "describe",
    "spread_states",
]

OUT_OF_PROCESS = False
"""A step takes microseconds: it needs no process of its own."""

_RUNNING, _GOAL, _LOST, _TIME_UP = map(
    int, (Outcome.RUNNING, Outcome.GOAL, Outcome.LOST, Outcome.TIME_UP)
)


def describe(parameters: Mapping[str, object] | Parameters) -> TaskDescription:
    """Return the task's description.

    Args:
        parameters: as in a protocol; omitted ones have their defaults.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    return described("navigation", 1, Parameters.model_validate(parameters))


def create(robots: int, parameters: Mapping[str, object] | Parameters) -> NavigationTask:
    """Make a fleet; every robot awaits its first reset.

    Args:
        robots: number of robots, n.
        parameters: as in a protocol; omitted ones have their defaults.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    return NavigationTask(robots, Parameters.model_validate(parameters))


def spread_states(
    parameters: Mapping[str, object] | Parameters, random: np.random.Generator, count: int
) -> Floats:
    """Draw states that a running robot can be in: uniform over floor, heading and health.

    Args:
        parameters: as in a protocol; omitted ones have their defaults.
        random: the stream to draw from.
        count: how many.

    Returns:
        float32 [count, 4].
    """
    return Dynamics(Parameters.model_validate(parameters)).spread_states(random, count)


class NavigationTask:
    """A fleet of robots in a map of rooms; a `SnapshotTask` and a `PlaceableTask`.

    States are as in `study.tasks._navigation_dynamics.Dynamics`.

    Args:
        robots: number of robots, n.
        parameters: dynamics and rewards.
    """

    def __init__(self, robots: int, parameters: Parameters) -> None:
        self.description = describe(parameters)
        self.robots = robots
        self.parameters = parameters
        self.dynamics = Dynamics(parameters)
        self.terrain = self.dynamics.terrain
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
            self._states[robot] = self.dynamics.start_state(random)
            noise = random.standard_normal((self.parameters.horizon, 3))
            self._noise[robot] = np.clip(noise, -NOISE_LIMIT, NOISE_LIMIT)
            self._outcomes[robot] = Outcome.RUNNING
            self._timesteps[robot] = 0
        self._measure(mask)
        return self._states.copy()

    def place(self, mask: Mask, states: Floats) -> Floats:
        """Put the robots in ``mask`` [n] that have not ended into ``states`` float32 [n, 4].

        Raises:
            ValueError: a state is off the floor, its heading out of range, or its health not
                in (0, 100].
        """
        x, y, heading, health = states[mask].astype(np.float64).T
        legal = self.terrain.is_legal(x, y) & (np.abs(heading) < np.pi)
        if not (legal & (health > 0) & (health <= FULL_HEALTH)).all():
            raise ValueError("a robot can only be put where one could be running")
        np.copyto(self._states, states, where=(mask & (self._outcomes == _RUNNING))[:, None])
        self._measure(mask)
        return self._states.copy()

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Step the robots in ``active`` [n] that have not ended by ``actions`` int32 [n].

        The outcome is decided last: lost before goal before time up.

        Raises:
            ValueError: an active robot's action is none of the task's.
        """
        stepped = active & (self._outcomes == _RUNNING)
        actions = np.where(stepped, actions, IDLE)
        if (actions.astype(np.uint32) >= len(ACTIONS)).any():
            raise ValueError(f"actions must be 0 to {len(ACTIONS) - 1}: {actions.tolist()}")
        at = np.minimum(self._timesteps, self.parameters.horizon - 1)
        noise = self._noise[self._rows, at]
        now = self.dynamics.transition(self._states, actions, noise, self._distances)

        outcomes = (self._timesteps + 1 >= self.parameters.horizon) * _TIME_UP
        outcomes[now.at_goal] = _GOAL
        outcomes[now.lost] = _LOST
        np.copyto(self._states, now.states, where=stepped[:, None])
        np.copyto(self._outcomes, outcomes, where=stepped, casting="same_kind")
        np.copyto(self._distances, now.distances, where=stepped)
        self._timesteps += stepped
        return FleetStep(
            states=self._states.copy(),
            rewards=np.where(stepped, now.rewards, 0.0).astype(np.float32),
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

    def _measure(self, mask: Mask) -> None:
        """Measure afresh how far the robots in ``mask`` are from the goal."""
        x, y = self._states.astype(np.float64).T[:2]
        np.copyto(self._distances, self.terrain.goal_distance(x, y), where=mask)
