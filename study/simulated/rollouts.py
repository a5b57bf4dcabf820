"""Driving fleets by a policy and adding up what they earn: Monte-Carlo's side of each check."""

from __future__ import annotations

import dataclasses
from typing import Protocol

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.tasks.base import PlaceableTask

Floats = npt.NDArray[np.float64]
States = npt.NDArray[np.float32]


class Acting(Protocol):
    """Whatever chooses actions: a policy, or the synthetic user."""

    def actions(self, states: States, random: np.random.Generator) -> npt.NDArray[np.int32]:
        """Return an action int32 [n] for each of n states float32 [n, d]."""
        ...


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Rollouts:
    """n robots driven for up to T timesteps, each until its episode ended.

    Attributes:
        states: float32 [T + 1, n, d]; a robot that has ended stays where it is.
        actions: int32 [T, n].
        rewards: float64 [T, n], points; 0 once a robot has ended.
        running: bool [T, n], whether the robot had not ended before the timestep.
        outcomes: int32 [n], codes.Outcome after the last timestep.
    """

    states: States
    actions: npt.NDArray[np.int32]
    rewards: Floats
    running: npt.NDArray[np.bool_]
    outcomes: npt.NDArray[np.int32]

    def points(self) -> Floats:
        """Return what each robot earned, undiscounted, float64 [n]."""
        total: Floats = self.rewards.sum(axis=0)
        return total

    def returns(self, discount: float) -> Floats:
        """Return what each robot earned from each timestep on, discounted, float64 [T, n]."""
        returns = np.zeros_like(self.rewards)
        later = np.zeros(self.rewards.shape[1])
        for timestep in range(len(returns) - 1, -1, -1):
            later = self.rewards[timestep] + discount * later
            returns[timestep] = later
        return returns


def roll_out(
    task: PlaceableTask,
    policy: Acting,
    seeds: npt.NDArray[np.uint64],
    random: np.random.Generator,
    *,
    states: States | None = None,
    timesteps: int | None = None,
    everyone: bool = False,
) -> Rollouts:
    """Drive each robot of a fleet by a policy until its episode ends.

    Args:
        task: a fleet of n robots; it is reset.
        policy: who drives.
        seeds: uint64 [n], of starts and noise: the same seeds give paired starts and noise.
        random: the policy's stream.
        states: float32 [n, d], where the robots are put instead of the task's own starts.
        timesteps: at most this many, T; default: the task's horizon.
        everyone: whether the policy is asked about robots that have ended too, so that what it
            draws for a robot does not hang on how the others fare.
    """
    every = np.ones(task.robots, np.bool_)
    now = task.reset(every, seeds)
    if states is not None:
        now = task.place(every, states)
    running = every.copy()
    outcomes = np.full(task.robots, Outcome.RUNNING, np.int32)
    seen, acted, earned, ran = [now], [], [], []
    for _ in range(task.description.horizon if timesteps is None else timesteps):
        if not running.any():
            break
        # Only those still running are asked: a policy's time goes with its states.
        asked = every if everyone else running
        actions = np.full(task.robots, task.description.idle_action, np.int32)
        actions[asked] = policy.actions(now[asked], random)
        step = task.step(actions, running)
        now, outcomes = step.states, step.outcomes
        seen.append(now)
        acted.append(actions)
        earned.append(step.rewards.astype(np.float64))
        ran.append(running)
        running = outcomes == Outcome.RUNNING
    shape = (len(acted), task.robots)
    return Rollouts(
        states=np.stack(seen),
        actions=np.array(acted, np.int32).reshape(shape),
        rewards=np.array(earned, np.float64).reshape(shape),
        running=np.array(ran, np.bool_).reshape(shape),
        outcomes=outcomes,
    )
