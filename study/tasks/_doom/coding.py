"""From states, float32 in metres, radians and points, to engines' whole numbers, and back.

Nothing is lost either way once a state is on the engine's grid: a fleet's states are then all
that its engines depend on, and frames are a function of the states.
"""

from __future__ import annotations

import numpy as np

from study.tasks._doom.arena import COMMAND, POSE
from study.tasks._doom.conventions import TICS
from study.tasks._doom.crew import Numbers
from study.tasks._doom.plane import GRID, UNITS
from study.tasks._navigation_dynamics import BACKWARD, FORWARD, Exact
from study.tasks.base import Floats, Ints

_SCALE = UNITS * GRID
_FIXED = 65536
_ANGLES = _FIXED // TICS
"""Headings an engine can have: whole numbers of turns a tic lead from one to another."""


def to_poses(states: Floats) -> Numbers:
    """Return the poses, int64 [n, 6], at rest, of states float32 [n, 4]."""
    x, y, heading, health = states.astype(np.float64).T
    poses = np.zeros((len(states), POSE), np.int64)
    poses[:, 0] = np.rint(x * _SCALE)
    poses[:, 1] = np.rint(y * _SCALE)
    poses[:, 2] = TICS * to_angles(heading)
    poses[:, 3] = np.rint(health * _FIXED)
    return poses


def to_states(poses: Numbers, heading: Exact) -> Floats:
    """Return the states, float32 [n, 4], of poses int64 [n, 6] and headings float64 [n].

    An engine's angle is its heading rounded; the heading itself is kept beside it.
    """
    x, y, _, health, *_ = poses.T
    return np.stack([x / _SCALE, y / _SCALE, heading, health / _FIXED], axis=1).astype(np.float32)


def to_angles(heading: Exact) -> Numbers:
    """Return the engine's angles, 1/16384 turns, of headings float64 [n]."""
    return np.rint(heading / (2 * np.pi) * _ANGLES).astype(np.int64) % _ANGLES


def to_commands(actions: Ints, heading: Exact, turned: Exact) -> Numbers:
    """Return the commands, int64 [n, 3], of actions that turn ``heading`` to ``turned`` [n]."""
    commands = np.zeros((len(actions), COMMAND), np.int64)
    commands[:, 0] = actions == FORWARD
    commands[:, 1] = actions == BACKWARD
    turn = to_angles(turned) - to_angles(heading)
    commands[:, 2] = (turn + _ANGLES // 2) % _ANGLES - _ANGLES // 2
    return commands
