"""The arena's physics, in MuJoCo; needs the extra ``jetbot``."""

from __future__ import annotations

import importlib
import math
import os
import sys
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from study.arena.course import MOST_ROBOTS, Course
from study.arena.model import TRACK, WHEEL_RADIUS, arena_mjcf
from study.errors import StudyError

STEP_S = 0.005
"""Physics step, seconds; a task's timestep is divided into steps of at most this."""

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


def load_mujoco() -> ModuleType:
    """Import MuJoCo, drawing without a display where the machine can.

    Raises:
        StudyError: it is not installed.
    """
    if sys.platform == "linux":
        # MuJoCo reads it when it is imported; without it, it looks for a window system.
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        return importlib.import_module("mujoco")
    except ImportError as error:
        raise StudyError(
            "the JetBots' arena needs MuJoCo, which is not installed",
            "In a clone `make jetbot`, elsewhere pip install 'scaled-autonomy[jetbot]'.",
        ) from error


def wheel_speeds(linear: float, angular: float) -> tuple[float, float]:
    """Return the speeds of the left and right wheel, rad/s, for a velocity in m/s and rad/s."""
    across = angular * TRACK / 2
    return (linear - across) / WHEEL_RADIUS, (linear + across) / WHEEL_RADIUS


class ArenaPhysics:
    """n robots in one arena; deterministic given what it is told.

    Args:
        course: the arena.
        robots: number of robots, n, 1 to `MOST_ROBOTS`.
        motor_lag_s: time constant of the motors, seconds.
        step_s: physics step, seconds.

    Raises:
        StudyError: MuJoCo is not installed, or there are too many robots.
    """

    def __init__(
        self, course: Course, robots: int, *, motor_lag_s: float, step_s: float = STEP_S
    ) -> None:
        if not 1 <= robots <= MOST_ROBOTS:
            raise StudyError(
                f"{robots} robots in the JetBots' arena; it has room for 1 to {MOST_ROBOTS}",
                "Make the fleets of the protocol smaller.",
            )
        self._mujoco: Any = load_mujoco()
        self.course = course
        self.robots = robots
        self.step_s = step_s
        text = arena_mjcf(course, robots, motor_lag_s=motor_lag_s, step_s=step_s)
        self.model: Any = self._mujoco.MjModel.from_xml_string(text)
        self.data: Any = self._mujoco.MjData(self.model)
        numbers = [
            [self.model.joint(f"robot{robot}{part}").id for part in ("", "_left", "_right")]
            for robot in range(robots)
        ]
        places, speeds = self.model.jnt_qposadr, self.model.jnt_dofadr
        # Of each robot: seven numbers of its pose, two wheel angles; six speeds, two of wheels.
        self._places = np.array(
            [[*range(places[a], places[a] + 7), places[b], places[c]] for a, b, c in numbers]
        )
        self._speeds = np.array(
            [[*range(speeds[a], speeds[a] + 6), speeds[b], speeds[c]] for a, b, c in numbers]
        )
        self._motors = np.arange(2 * robots).reshape(robots, 2)
        self._whole_state = int(self._mujoco.mjtState.mjSTATE_INTEGRATION)

    def clear(self) -> None:
        """Forget everything, so that what follows does not depend on what went before."""
        self._mujoco.mj_resetData(self.model, self.data)

    def put(self, robot: int, x: float, y: float, heading: float) -> None:
        """Put one robot somewhere, at rest with its motors off; metres, radians."""
        half = heading / 2
        self.data.qpos[self._places[robot]] = (
            *(x, y, WHEEL_RADIUS),
            *(math.cos(half), 0.0, 0.0, math.sin(half)),
            *(0.0, 0.0),
        )
        self.data.qvel[self._speeds[robot]] = 0.0
        self.data.act[self._motors[robot]] = 0.0
        self.data.ctrl[self._motors[robot]] = 0.0

    def set_wheels(self, robot: int, left: float, right: float) -> None:
        """Set what one robot's motors aim for, rad/s."""
        self.data.ctrl[self._motors[robot]] = left, right

    def advance(self, steps: int, moving: Mask) -> None:
        """Go on by a number of physics steps.

        Args:
            steps: how many.
            moving: bool [n]; the others stand like rocks, their motors' state kept.
        """
        data, step = self.data, self._mujoco.mj_step
        if moving.all():
            step(self.model, data, nstep=steps)
            return
        places, speeds = self._places[~moving].ravel(), self._speeds[~moving].ravel()
        motors = self._motors[~moving].ravel()
        kept_places, kept_motors = data.qpos[places].copy(), data.act[motors].copy()
        for _ in range(steps):
            step(self.model, data)
            data.qpos[places] = kept_places
            data.qvel[speeds] = 0.0
            data.act[motors] = kept_motors

    def look(self) -> None:
        """Bring what is drawn up to date with where robots were put; the future stays the same."""
        self._mujoco.mj_kinematics(self.model, self.data)
        self._mujoco.mj_camlight(self.model, self.data)

    def poses(self) -> Floats:
        """Return x, y (metres) and heading (-pi to pi) of all robots, float64 [n, 3]."""
        seven = self.data.qpos[self._places[:, :7]]
        w, x, y, z = seven[:, 3:].T
        heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y**2 + z**2))
        return np.column_stack([seven[:, :2], heading])

    def velocities(self) -> Floats:
        """Return forward speed (m/s) and turn rate (rad/s) of all robots, float64 [n, 2]."""
        heading = self.poses()[:, 2]
        speeds = self.data.qvel[self._speeds]
        forward = speeds[:, 0] * np.cos(heading) + speeds[:, 1] * np.sin(heading)
        return np.column_stack([forward, speeds[:, 5]])

    def state(self) -> Floats:
        """Return all that determines the future, float64 [k]."""
        kept = np.empty(self._mujoco.mj_stateSize(self.model, self._whole_state))
        self._mujoco.mj_getState(self.model, self.data, kept, self._whole_state)
        return kept

    def set_state(self, kept: Floats) -> None:
        """Put back what `state` returned."""
        self._mujoco.mj_setState(self.model, self.data, kept, self._whole_state)
