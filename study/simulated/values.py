"""Values of a policy by temporal differences, and how well they agree with Monte-Carlo.

TD(lambda) (Sutton, 1988) regresses on lambda-returns: a mixture of what was earned in the
following timesteps and of the value estimated for where that led. At a discount of 0.99 the
estimates of others' estimates go wrong without a sign of it: whatever was fitted is therefore
held against rollouts that it has not seen: R^2 says how well they agree. Fitting
needs torch and is done by `study.training.value_fit`; here is all that needs none.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.perceptron import Perceptron
from study.simulated.landmarks import Landmarks
from study.simulated.rollouts import Rollouts
from study.simulated.value_gain import Valuing

Floats = npt.NDArray[np.float64]
States = npt.NDArray[np.float32]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class FittedValues:
    """V of one policy.

    Attributes:
        network: features to V, in deviations from the mean.
        landmarks: what turns states into features.
        mean: of V over the data that it was fitted to, points.
        deviation: of the same, points.
    """

    network: Perceptron
    landmarks: Landmarks
    mean: float
    deviation: float

    def values(self, states: States) -> Floats:
        """Return V of each of n states.

        Args:
            states: float32 [n, d].

        Returns:
            float64 [n], points.
        """
        scaled = self.network(self.landmarks.features(states))[..., 0]
        return self.mean + self.deviation * scaled

    def unscaled(self) -> Perceptron:
        """Return the network with mean and deviation worked into its last layer."""
        *hidden, (weight, bias) = self.network.layers
        last = (weight * self.deviation, bias * self.deviation + self.mean)
        return Perceptron((*hidden, last))


def lambda_returns(
    rollouts: Rollouts, discount: float, trace: float, values: Valuing | None
) -> Floats:
    """Return the lambda-return of each robot at each timestep.

    G_t = r_t + discount ((1 - trace) V(s_t+1) + trace G_t+1). After a goal or a loss nothing is
    earned; where an episode was only cut off, V of where it was takes the place of the rest.

    Args:
        rollouts: T timesteps of n robots.
        discount: gamma.
        trace: lambda; 1 is Monte-Carlo, 0 looks one timestep ahead.
        values: the estimate so far; None counts as 0 everywhere.

    Returns:
        float64 [T, n], points; 0 where a robot was not running.
    """
    timesteps, robots = rollouts.rewards.shape
    estimated = np.zeros((timesteps + 1, robots))
    if values is not None:
        flat = rollouts.states.reshape(-1, rollouts.states.shape[-1])
        estimated = values.values(flat).reshape(timesteps + 1, robots)
    ended = np.isin(rollouts.outcomes, (Outcome.GOAL, Outcome.LOST))
    returns = np.zeros((timesteps, robots))
    onwards = np.where(ended, 0.0, estimated[-1])
    for timestep in range(timesteps - 1, -1, -1):
        runs_on = np.zeros(robots, np.bool_)
        if timestep + 1 < timesteps:
            runs_on = rollouts.running[timestep + 1]
        ahead = (1 - trace) * estimated[timestep + 1] + trace * onwards
        # Where the episode ended here, `onwards` is still what follows its end.
        following = np.where(runs_on, ahead, np.where(ended, 0.0, estimated[-1]))
        now = rollouts.rewards[timestep] + discount * following
        onwards = np.where(rollouts.running[timestep], now, onwards)
        returns[timestep] = np.where(rollouts.running[timestep], now, 0.0)
    return returns


def r_squared(estimates: Floats, measured: Floats) -> float:
    """Return the part of the measured values' variance that estimates [m] explain.

    Raises:
        ValueError: all measured values [m] are equal: there is nothing to explain.
    """
    spread = float(((measured - measured.mean()) ** 2).sum())
    if spread <= 0.0:
        raise ValueError("R^2 needs measured values that differ")
    return 1.0 - float(((measured - estimates) ** 2).sum()) / spread


def agreement(values: Valuing, rollouts: Rollouts, discount: float) -> float:
    """Return R^2 of values against what rollouts earned from each state on.

    1 is perfect, 0 no better than the mean of what was earned, below 0 worse.

    Args:
        values: V.
        rollouts: not used in its fit; long enough that what lies beyond hardly counts.
        discount: gamma.
    """
    where = rollouts.running
    measured = rollouts.returns(discount)[where]
    return r_squared(values.values(rollouts.states[:-1][where]), measured)
