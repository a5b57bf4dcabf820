"""Fleets side by side in one batch: the same starts and noise, and a new start after each end.

Robot i of every fleet has the same seeds, and a policy that nobody overrides does the same with
them: two fleets differ only by what the user did in them. That makes comparisons sharp, and it
makes them cheap, because what the policy does is computed once where states are equal.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.policies.base import Policy
from study.seeding import generator

States = npt.NDArray[np.float32]
Floats = npt.NDArray[np.float64]
Actions = npt.NDArray[np.int32]


class Fleets:
    """F fleets of n robots.

    Args:
        task: the task's module.
        parameters: of the task.
        fleets: F.
        robots: n.
        seed: of the world.
        name: what the fleets are for; keys their seeds.
        paired: whether all fleets share starts and noise; else each has its own, and those of
            fleet f do not depend on how many fleets there are.

    Attributes:
        states: float32 [F, n, d], now.
        endings: int64 [F, outcomes], how many episodes ended in each way.
    """

    def __init__(
        self,
        task: ModuleType,
        parameters: dict[str, Any],
        *,
        fleets: int,
        robots: int,
        seed: int,
        name: str,
        paired: bool,
    ) -> None:
        self._shape = (fleets, robots)
        self._task = task.create(fleets * robots, parameters)
        self._seed, self._name, self._paired = seed, name, paired
        self._every = np.ones(fleets * robots, np.bool_)
        self._episodes = np.zeros(fleets * robots, np.int64)
        self._seeds: list[npt.NDArray[np.uint64]] = []
        self.endings = np.zeros((fleets, max(Outcome) + 1), np.int64)
        self._set(self._task.reset(self._every, self._episode_seeds(self._every)))

    def step(self, actions: Actions) -> Floats:
        """Step every robot by actions int32 [F, n]; those that ended start anew.

        Returns:
            Rewards float64 [F, n].
        """
        step = self._task.step(actions.reshape(-1), self._every)
        ended = step.outcomes != Outcome.RUNNING
        states = step.states
        if ended.any():
            fleets = np.flatnonzero(ended) // self._shape[1]
            np.add.at(self.endings, (fleets, step.outcomes[ended]), 1)
            self._episodes += ended
            states = self._task.reset(ended, self._episode_seeds(ended))
        self._set(states)
        rewards: Floats = step.rewards.astype(np.float64).reshape(self._shape)
        return rewards

    def policy_actions(self, policy: Policy, random: np.random.Generator) -> Actions:
        """Return what a deterministic policy does in every state, int32 [F, n].

        Where a robot's state is that of the first fleet's, the action is too.
        """
        first = self.states[0]
        actions = np.broadcast_to(policy.actions(first, random), self._shape).copy()
        differs = (self.states != first).any(axis=-1)
        if differs.any():
            actions[differs] = policy.actions(self.states[differs], random)
        return actions

    def _set(self, states: States) -> None:
        self.states: States = states.reshape(*self._shape, -1)

    def _episode_seeds(self, mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint64]:
        """Return each robot's seed for its present episode; 0 outside ``mask``."""
        fleets, robots = self._shape
        seeds = np.zeros(fleets * robots, np.uint64)
        rows = np.flatnonzero(mask)
        drawn = 1 if self._paired else fleets
        while len(self._seeds) <= self._episodes[rows].max(initial=0):
            random = generator(self._seed, f"{self._name} episodes", len(self._seeds))
            self._seeds.append(random.integers(2**63, size=drawn * robots, dtype=np.uint64))
        table = np.stack(self._seeds)
        columns = rows % robots if self._paired else rows
        seeds[rows] = table[self._episodes[rows], columns]
        return seeds


def drawn_actions(chances: Floats, marks: Floats) -> Actions:
    """Return for each row of chances [m, actions] the action that a mark in [0, 1) falls on.

    Args:
        chances: rows that add up to 1.
        marks: float64 [m]; fleets that share them share the user's noise.
    """
    upto = chances.cumsum(axis=-1)
    actions: Actions = (marks[:, None] * upto[:, -1:] >= upto[:, :-1]).sum(axis=-1)
    return actions.astype(np.int32)
