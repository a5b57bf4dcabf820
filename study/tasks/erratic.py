"""The rehearsal task: a stand-in for a live robot that nobody can repeat.

Its states come from the operating system's entropy, its steps take as long as they like
and its episodes end when they like. A session that records, replays and analyses with it
shows that nothing downstream depends on a task being deterministic or quick.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from study.events.codes import Outcome
from study.events.scene import DiscMark, RectangleMark, Scene
from study.events.task_description import RewardTerm, StateField, TaskDescription
from study.tasks.base import FleetStep, Floats, Ints, Mask, Seeds

OUT_OF_PROCESS = True
"""Steps are slow: they must not hold up the window."""

ACTIONS = ("forward", "backward", "turn left", "turn right", "idle")
SIZE = 10.0
"""Side of the one room, metres."""


class Parameters(BaseModel):
    """What a protocol can set of the task."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    horizon: int = Field(200, ge=1, description="longest episode, timesteps")
    slowest_ms: float = Field(
        30.0, ge=0, le=10_000, description="a step takes 0 to this many milliseconds"
    )
    end_chance: float = Field(
        0.01, ge=0, le=1, description="chance at each timestep that a robot's episode ends"
    )


def describe(parameters: Mapping[str, object] | Parameters) -> TaskDescription:
    """Return the task's description.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    settings = Parameters.model_validate(parameters)
    return TaskDescription(
        name="erratic",
        version=1,
        state_fields=(
            StateField("x", "m", 0.0, SIZE),
            StateField("y", "m", 0.0, SIZE),
            StateField("heading", "rad", -math.pi, math.pi, circular=True),
            StateField("health", "points", 0.0, 100.0),
        ),
        x_field=0,
        y_field=1,
        heading_field=2,
        health_field=3,
        action_names=ACTIONS,
        idle_action=ACTIONS.index("idle"),
        key_actions={"up": 0, "down": 1, "left": 2, "right": 3},
        horizon=settings.horizon,
        rewards=(RewardTerm("progress", 1.0, "each metre", "to the right"),),
        scene=Scene(
            width=SIZE,
            height=SIZE,
            rectangles=(RectangleMark("room", 0.0, 0.0, SIZE, SIZE),),
            discs=(DiscMark("goal", SIZE - 1, SIZE / 2, 1.0), DiscMark("start", 1.0, 1.0, 0.8)),
            plate=None,
            robot_radius=0.35,
        ),
        map_grid=None,
        resimulable="no",
    )


def create(robots: int, parameters: Mapping[str, object] | Parameters) -> ErraticTask:
    """Make a fleet; every robot awaits its first reset.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    return ErraticTask(robots, Parameters.model_validate(parameters))


class ErraticTask:
    """Robots that are jostled about whatever they are told; a `study.tasks.base.Task`.

    Args:
        robots: number of robots, n.
        parameters: how slow and how erratic.
    """

    def __init__(self, robots: int, parameters: Parameters) -> None:
        self.description = describe(parameters)
        self.robots = robots
        self.parameters = parameters
        # The one place that must not be reproducible: entropy instead of a seed.
        self._random = np.random.default_rng(int.from_bytes(os.urandom(16), "little"))
        self._states = np.zeros((robots, 4), np.float32)
        self._outcomes = np.full(robots, int(Outcome.TIME_UP), np.int32)
        self._timesteps = np.zeros(robots, np.int32)

    def reset(self, mask: Mask, seeds: Seeds) -> Floats:
        """Start new episodes for the robots in ``mask`` [n]; ``seeds`` are ignored.

        Returns:
            States of all robots, float32 [n, 4].
        """
        del seeds
        self._wait()
        drawn = self._random.uniform(
            (1, 1, -math.pi, 60), (SIZE - 1, SIZE - 1, math.pi, 100), (self.robots, 4)
        )
        self._keep(drawn, mask)
        self._outcomes[mask] = Outcome.RUNNING
        self._timesteps[mask] = 0
        return self._states.copy()

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Step the robots in ``active`` [n] that have not ended; leave the others alone."""
        self._wait()
        stepped = active & (self._outcomes == Outcome.RUNNING)
        before = self._states.astype(np.float64)
        turn = np.array([0.0, 0.0, 0.3, -0.3, 0.0])[actions]
        travel = np.array([0.4, -0.3, 0.0, 0.0, 0.0])[actions]
        after = before + self._random.normal(0, (0.1, 0.1, 0.1, 1.0), before.shape)
        after[:, 0] += travel * np.cos(before[:, 2])
        after[:, 1] += travel * np.sin(before[:, 2])
        after[:, 2] = (after[:, 2] + turn + math.pi) % (2 * math.pi) - math.pi
        self._keep(after, stepped)
        self._timesteps += stepped
        ended = stepped & (self._random.random(self.robots) < self.parameters.end_chance)
        kinds = self._random.choice([int(Outcome.GOAL), int(Outcome.LOST)], self.robots)
        self._outcomes[ended] = kinds[ended]
        late = stepped & ~ended & (self._timesteps >= self.parameters.horizon)
        self._outcomes[late] = Outcome.TIME_UP
        return FleetStep(
            states=self._states.copy(),
            rewards=(self._states[:, 0] - before[:, 0]).astype(np.float32),
            outcomes=self._outcomes.copy(),
        )

    def close(self) -> None:
        """Do nothing: the task holds memory only."""

    def _wait(self) -> None:
        time.sleep(self._random.uniform(0, self.parameters.slowest_ms) / 1000)

    def _keep(self, states: np.ndarray[tuple[int, ...], np.dtype[np.float64]], mask: Mask) -> None:
        """Put states, held within their fields' ranges, in place of those in ``mask``."""
        half_turn = float(np.nextafter(np.float32(np.pi), np.float32(0)))
        held = np.clip(states, (0, 0, -half_turn, 1), (SIZE, SIZE, half_turn, 100))
        self._states[mask] = held[mask]
