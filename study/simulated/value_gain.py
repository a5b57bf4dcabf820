"""What taking control is worth: the paper's ground truth, phi(s) = V_user(s) - V_robot(s).

"Simulation Experiments" of the paper: the user's true scores are the difference between what
the user will earn from a state on and what the robot's own policy will.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
States = npt.NDArray[np.float32]


class Valuing(Protocol):
    """Whatever knows the values of states: `TrainedUser`, `FittedValues`, `GridValues`."""

    def values(self, states: States) -> Floats:
        """Return V float64 [n], points, of each of n states float32 [n, d]."""
        ...


class ValueGain:
    """phi, a `study.scorers.base.Scorer` that needs no fit.

    Args:
        user: V of whoever takes control.
        robot: V of the policy that drives otherwise.
    """

    def __init__(self, user: Valuing, robot: Valuing) -> None:
        self.user = user
        self.robot = robot

    def scores(self, states: States) -> Floats:
        """Return V_user - V_robot of each of n states.

        Args:
            states: float32 [n, d].

        Returns:
            float64 [n], points.
        """
        return self.user.values(states) - self.robot.values(states)
