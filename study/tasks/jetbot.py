"""Laps round two buckets with robots of two wheels, all in one arena, where they may collide.

A robot's state is its pose and how many gates of its lap it has passed: what the next points
depend on. Left out, so that a policy sees what motion capture sees of one robot: the speed, which
the motors' lag forgets within a timestep, and the other robots. A robot that is not stepped
stands where it is, and others drive into it.

An episode's start, its motors' bias and all its noise come from the robot's seed at reset.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from study.arena.cameras import Cameras, open_cameras
from study.arena.course import ROBOT_RADIUS, TWO_BUCKETS
from study.arena.laps import Progress, advance
from study.arena.physics import STEP_S, ArenaPhysics, wheel_speeds
from study.events.codes import Outcome
from study.events.task_description import RewardTerm, StateField, TaskDescription
from study.tasks._jetbot_needs import check_live, missing_extra, open_emergency
from study.tasks._jetbot_parameters import (
    ACTIONS,
    BACKWARD,
    FORWARD,
    IDLE,
    TURN_LEFT,
    TURN_RIGHT,
    Parameters,
)
from study.tasks.base import FleetStep, Floats, Ints, Mask, Seeds

if TYPE_CHECKING:
    from study.tasks._jetbot_linked import LinkedJetbotTask

__all__ = [
    "OUT_OF_PROCESS",
    "JetbotTask",
    "Parameters",
    "check_live",
    "create",
    "describe",
    "missing_extra",
    "open_emergency",
]

OUT_OF_PROCESS = True
"""A timestep of three robots takes a millisecond or two, pictures more."""

NOISE_LIMIT = 3.0
"""Standard deviations: no wheel is ever thrown."""

_START_TRIES = 200
_START_GAP = 0.5 * ROBOT_RADIUS
_HEADING_SPREAD = 0.3
_GRID_CELL = 0.1
_HALF_TURN = float(np.nextafter(np.float32(np.pi), np.float32(0)))


def describe(parameters: Mapping[str, object] | Parameters) -> TaskDescription:
    """Return the task's description; MuJoCo is not needed for it.

    Args:
        parameters: as in a protocol; omitted ones have their defaults.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    settings = Parameters.model_validate(parameters)
    course = TWO_BUCKETS
    return TaskDescription(
        name="jetbot",
        version=1,
        state_fields=(
            StateField("x", "m", 0.0, course.width),
            StateField("y", "m", 0.0, course.height),
            StateField("heading", "rad", -math.pi, math.pi, circular=True),
            StateField("gates", "gates", 0.0, len(course.gates) - 1.0),
        ),
        x_field=0,
        y_field=1,
        heading_field=2,
        health_field=-1,
        action_names=ACTIONS,
        idle_action=IDLE,
        key_actions={"up": FORWARD, "down": BACKWARD, "left": TURN_LEFT, "right": TURN_RIGHT},
        horizon=settings.horizon,
        rewards=(RewardTerm("lap", settings.lap, "each lap", "round both buckets, anticlockwise"),),
        scene=dataclasses.replace(course.scene(), camera=settings.cameras),
        map_grid=course.map_grid(_GRID_CELL, (0.0, math.pi / 2, math.pi, -math.pi / 2)),
        resimulable="no" if settings.link else "exact",
        instruction="Drive laps round both buckets, anticlockwise.",
    )


def create(
    robots: int, parameters: Mapping[str, object] | Parameters
) -> JetbotTask | LinkedJetbotTask:
    """Make a fleet; every robot awaits its first reset.

    With a link, the robots are connected, and all must be live.

    Args:
        robots: number of robots, n, 1 to `study.arena.course.MOST_ROBOTS`.
        parameters: as in a protocol; omitted ones have their defaults.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
        StudyError: an extra is not installed, there are too many robots, or one is not live.
    """
    settings = Parameters.model_validate(parameters)
    if settings.link:
        from study.tasks import _jetbot_linked as linked  # noqa: PLC0415 - threads, sockets

        made = linked.PicturedLinkedJetbotTask if settings.cameras else linked.LinkedJetbotTask
        return made(robots, settings, describe(settings))
    return (PicturedJetbotTask if settings.cameras else JetbotTask)(robots, settings)


class JetbotTask:
    """A fleet in one simulated arena; a `SnapshotTask`.

    States are float32 [n, 4]: x and y (m), heading (rad), gates passed since the last lap.

    Args:
        robots: number of robots, n.
        parameters: motion, time and points.

    Raises:
        StudyError: MuJoCo is not installed, or there are too many robots.
    """

    def __init__(self, robots: int, parameters: Parameters) -> None:
        self.description = describe(parameters)
        self.robots = robots
        self.parameters = parameters
        self.course = TWO_BUCKETS
        timestep_s = 1 / parameters.timesteps_per_second
        self._steps = math.ceil(timestep_s / STEP_S - 1e-9)
        self.physics = ArenaPhysics(
            self.course,
            robots,
            motor_lag_s=parameters.motor_lag,
            step_s=timestep_s / self._steps,
        )
        self._states = np.zeros((robots, 4), np.float32)
        # A robot that was never reset counts as ended.
        self._outcomes = np.full(robots, Outcome.TIME_UP, np.int32)
        self._timesteps = np.zeros(robots, np.int32)
        self._places = self.physics.poses()[:, :2]
        self._passed = np.zeros((robots, 2), np.int32)
        self._noise = np.zeros((robots, parameters.horizon, 2))

    def reset(self, mask: Mask, seeds: Seeds) -> Floats:
        """Start new episodes for the robots in ``mask`` [n]; ``seeds`` uint64 [n].

        Each starts behind the finish line, clear of the others.

        Returns:
            States of all robots, float32 [n, 4].
        """
        if mask.all():
            self.physics.clear()
        standing = [tuple(place) for place in self._places[~mask]]
        for robot in map(int, np.flatnonzero(mask)):
            random = np.random.Generator(np.random.PCG64(np.random.SeedSequence(int(seeds[robot]))))
            x, y = self._start(random, standing)
            standing.append((x, y))
            heading = self.course.start.heading + random.uniform(-_HEADING_SPREAD, _HEADING_SPREAD)
            self.physics.put(robot, x, y, heading)
            limit, horizon = NOISE_LIMIT, self.parameters.horizon
            bias = np.clip(random.standard_normal(2), -limit, limit) * self.parameters.wheel_bias
            noise = np.clip(random.standard_normal((horizon, 2)), -limit, limit)
            self._noise[robot] = 1 + bias + noise * self.parameters.noise
            self._outcomes[robot] = Outcome.RUNNING
            self._timesteps[robot] = 0
            self._passed[robot] = 0
        self._observe(mask)
        return self._states.copy()

    def _start(
        self, random: np.random.Generator, standing: list[tuple[float, float]]
    ) -> tuple[float, float]:
        """Draw where a robot starts: clear of the others, or as far from them as found."""
        region = self.course.start
        drawn = random.uniform(
            (region.x, region.y),
            (region.x + region.width, region.y + region.height),
            (_START_TRIES, 2),
        )
        if not standing:
            return float(drawn[0, 0]), float(drawn[0, 1])
        apart = np.linalg.norm(drawn[:, None] - np.array(standing)[None], axis=2).min(axis=1)
        clear = np.flatnonzero(apart >= 2 * ROBOT_RADIUS + _START_GAP)
        best = drawn[clear[0] if clear.size else int(apart.argmax())]
        return float(best[0]), float(best[1])

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Step the robots in ``active`` [n] that have not ended by ``actions`` int32 [n].

        Raises:
            ValueError: an active robot's action is none of the task's.
        """
        stepped = active & (self._outcomes == Outcome.RUNNING)
        if (actions[stepped].astype(np.uint32) >= len(ACTIONS)).any():
            raise ValueError(f"actions must be 0 to {len(ACTIONS) - 1}: {actions.tolist()}")
        for robot in map(int, np.flatnonzero(stepped)):
            factors = self._noise[robot, self._timesteps[robot]]
            wheels = wheel_speeds(*self.parameters.velocity(int(actions[robot])))
            self.physics.set_wheels(robot, wheels[0] * factors[0], wheels[1] * factors[1])
        self.physics.advance(self._steps, stepped)
        laps = self._count_laps(stepped)
        self._timesteps += stepped
        self._observe(stepped)
        late = stepped & (self._timesteps >= self.parameters.horizon)
        self._outcomes[late] = Outcome.TIME_UP
        rewards = (laps * self.parameters.lap).astype(np.float32)
        return FleetStep(self._states.copy(), rewards, self._outcomes.copy())

    def _count_laps(self, stepped: Mask) -> npt.NDArray[np.int32]:
        """Return the laps that robots finished in this timestep, int32 [n]."""
        laps = np.zeros(self.robots, np.int32)
        poses = self.physics.poses()
        for robot in map(int, np.flatnonzero(stepped)):
            before = Progress(*map(int, self._passed[robot]))
            x, y = map(float, self._places[robot])
            now = advance(
                self.course, before, (x, y), (float(poses[robot, 0]), float(poses[robot, 1]))
            )
            laps[robot] = now.laps - before.laps
            self._passed[robot] = now.passed, now.laps
        return laps

    def _observe(self, mask: Mask) -> None:
        poses = self.physics.poses()
        self._places[mask] = poses[mask, :2]
        seen = np.column_stack([poses, self._passed[:, 0]])
        held = np.clip(
            seen,
            (0.0, 0.0, -_HALF_TURN, 0.0),
            (self.course.width, self.course.height, _HALF_TURN, len(self.course.gates) - 1.0),
        )
        self._states[mask] = held[mask]

    def snapshot(self) -> dict[str, npt.NDArray[Any]]:
        """Return copies of all arrays that determine the future, noise included."""
        kept = {name: array.copy() for name, array in self._memory().items()}
        return {**kept, "physics": self.physics.state()}

    def restore(self, snapshot: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put back what `snapshot` returned."""
        for name, array in self._memory().items():
            array[...] = snapshot[name]
        self.physics.set_state(snapshot["physics"])

    def close(self) -> None:
        """Do nothing: the task holds memory only."""

    def _memory(self) -> dict[str, npt.NDArray[Any]]:
        return {
            "states": self._states,
            "outcomes": self._outcomes,
            "timesteps": self._timesteps,
            "places": self._places,
            "passed": self._passed,
            "noise": self._noise,
        }


class PicturedJetbotTask(JetbotTask):
    """The same fleet with its front cameras; a `study.tasks.base.PicturedTask`.

    Args:
        robots: number of robots, n.
        parameters: motion, time and points.

    Raises:
        StudyError: MuJoCo is not installed, or there are too many robots.
    """

    def __init__(self, robots: int, parameters: Parameters) -> None:
        super().__init__(robots, parameters)
        self._cameras: Cameras | None = None

    def pictures(self) -> npt.NDArray[np.uint8]:
        """Return each robot's front camera as it is now, uint8 [n, height, width, 3].

        Where the machine has no EGL, the arena from above.
        """
        self.physics.look()
        if self._cameras is None:
            self._cameras = open_cameras(self.physics)
        return np.stack([self._cameras.picture(robot) for robot in range(self.robots)])

    def close(self) -> None:
        """Free the cameras. Calling it twice is harmless."""
        if self._cameras is not None:
            self._cameras.close()
            self._cameras = None
