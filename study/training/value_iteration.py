"""Soft value iteration and policy evaluation on a grid: an independent word on what is optimal.

V(s) = alpha log sum_a exp(Q(s, a) / alpha),  Q(s, a) = r(s, a) + gamma E[V(s')]. No network, no
sample and no learning rate is shared with the training that is checked against it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from study.simulated.rollouts import Acting
from study.training.grid_model import Floats, GridModel, States

_CHUNK = 200_000
_ERRORS = np.sqrt(2.0) * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class GridValues:
    """V on the nodes of a grid, and between them.

    Attributes:
        model: the task on the grid.
        nodes: float64 [k, levels], points.
        sweeps: how many it took.
        change: of V in the last sweep at most, points.
    """

    model: GridModel
    nodes: Floats
    sweeps: int
    change: float

    def values(self, states: States) -> Floats:
        """Return V of each of n states, interpolated; 0 where health is 0.

        Args:
            states: float32 [n, 4].

        Returns:
            float64 [n], points.
        """
        nodes, shares = self.model.grid.share(states)
        levels = self.model.grid.level_shares(states[:, 3].astype(np.float64))
        found: Floats = np.einsum("ms,msl,ml->m", shares, self.nodes[nodes], levels)
        return found


class SoftGridPolicy:
    """Drives by looking one timestep ahead to the grid's V, in the task's own states.

    Args:
        solved: V, soft-optimal.
        discount: gamma.
        temperature: alpha, points per nat.
    """

    def __init__(self, solved: GridValues, discount: float, temperature: float) -> None:
        self.solved = solved
        self._discount = discount
        self._temperature = temperature

    def actions(self, states: States, random: np.random.Generator) -> npt.NDArray[np.int32]:
        """Draw an action int32 [n] for each of n states float32 [n, 4]."""
        scaled = self.advantages(states) / self._temperature
        # The Gumbel trick draws from the softmax.
        drawn = (scaled + random.gumbel(size=scaled.shape)).argmax(axis=1)
        actions: npt.NDArray[np.int32] = drawn.astype(np.int32)
        return actions

    def advantages(self, states: States) -> Floats:
        """Return Q float64 [n, actions] of n states float32 [n, 4]."""
        model = self.solved.model
        count, found = len(states), np.zeros((len(states), len(model.actions)))
        for action in range(len(model.actions)):
            for error in _ERRORS:
                noise = np.tile([*error, 0.0], (count, 1))
                then = model.dynamics.transition(states, np.full(count, action), noise)
                onward = ~(then.lost | then.at_goal)
                values = np.where(onward, self.solved.values(then.states), 0.0)
                found[:, action] += (then.rewards + self._discount * values) / len(_ERRORS)
        return found


def solve(
    model: GridModel,
    discount: float = 0.99,
    temperature: float = 0.05,
    tolerance: float = 0.01,
    report: Callable[[int, float], None] | None = None,
) -> GridValues:
    """Iterate soft values until no node changes by more than a tolerance in a sweep.

    The distance from the fixed point is then at most ``tolerance * discount / (1 - discount)``
    points, and in practice far less.

    Args:
        model: the task on a grid.
        discount: gamma.
        temperature: alpha, points per nat; a return counts alpha points for each nat of entropy.
        tolerance: points.
        report: called after each sweep with its number and the change.
    """
    rewards = model.rewards()

    def backup(values: Floats) -> Floats:
        q = rewards + discount * model.ahead(values)
        best = q.max(axis=0)
        total = np.exp((q - best) / temperature).sum(axis=0)
        soft: Floats = best + temperature * np.log(total)
        return soft

    return _iterate(model, backup, tolerance, report)


def evaluate(
    model: GridModel,
    policy: Acting,
    random: np.random.Generator,
    discount: float = 0.99,
    tolerance: float = 0.01,
) -> GridValues:
    """Return V of a deterministic policy, such as nearest neighbour, on the grid.

    Args:
        model: the task on a grid.
        policy: asked once in each node.
        random: the policy's stream; a deterministic policy leaves it alone.
        discount: gamma.
        tolerance: points, as for `solve`.
    """
    levels = model.grid.levels
    actions = np.zeros((model.grid.nodes, len(levels)), np.intp)
    for column, health in enumerate(levels):
        states = model.grid.states(float(max(health, 1e-3)))
        for low in range(0, len(states), _CHUNK):
            part = slice(low, low + _CHUNK)
            actions[part, column] = policy.actions(states[part], random)
    rewards = np.take_along_axis(model.rewards(), actions[None], axis=0)[0]
    step = model.under(actions)

    def backup(values: Floats) -> Floats:
        following: Floats = rewards + discount * step(values)
        return following

    return _iterate(model, backup, tolerance, None)


def _iterate(
    model: GridModel,
    backup: Callable[[Floats], Floats],
    tolerance: float,
    report: Callable[[int, float], None] | None,
) -> GridValues:
    values = np.zeros((model.grid.nodes, len(model.grid.levels)))
    sweeps, change = 0, np.inf
    while change > tolerance:
        following = backup(values)
        # Health 0 is never a state to act in.
        following[:, 0] = 0.0
        change = float(np.abs(following - values).max())
        values = following
        sweeps += 1
        if report is not None:
            report(sweeps, change)
    return GridValues(model, values, sweeps, change)
