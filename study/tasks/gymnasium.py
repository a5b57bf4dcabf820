"""Any registered Gymnasium environment with discrete actions and pictures, as a fleet.

Named in a protocol by its id: ``gymnasium:CartPole-v1``. Each robot is an environment of its own.
Its state is the environment's observation as a row of numbers, its points are the environment's
reward. An episode starts from its seed alone.

Without its id the module is the family's file: `member` returns what stands for one environment.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Literal

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from study.errors import StudyError
from study.events.codes import Outcome
from study.events.task_description import TaskDescription
from study.tasks._gymnasium_environment import (
    Resolved,
    check_registered,
    make_environment,
    resolve,
)
from study.tasks._gymnasium_spaces import picture_of, row_of
from study.tasks.base import FleetStep, Floats, Ints, Mask, Seeds

OUT_OF_PROCESS = True
"""Nobody knows how long a foreign environment takes, nor what it does to the process."""

_RUNNING, _GOAL, _LOST, _TIME_UP = map(
    int, (Outcome.RUNNING, Outcome.GOAL, Outcome.LOST, Outcome.TIME_UP)
)


class Parameters(BaseModel):
    """What a protocol can set of an environment."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    options: dict[str, JsonValue] = Field(
        default_factory=dict, description="what the environment is made with, as `is_slippery`"
    )
    horizon: int | None = Field(
        None,
        ge=1,
        le=1_000_000,
        description="longest episode, timesteps; else the environment's own, or 200",
    )
    instruction: str = Field(
        "", max_length=200, description="one sentence for participants: what is to be done"
    )
    keys: dict[str, int] = Field(
        default_factory=dict,
        description="action of each key: `left`, `right`, `up`, `down`, `space` or a letter",
    )
    action_names: tuple[str, ...] = Field((), description="names of the actions, in order")
    without_key: int | Literal["wait"] | None = Field(
        None,
        description="the environment's action while no key is held; `wait`: it is not stepped",
    )
    termination: Literal["goal", "lost", "goal_if_rewarded"] | None = Field(
        None,
        description="what it means that the environment ends an episode; `goal_if_rewarded`: a "
        "goal if the last reward is positive, else lost",
    )
    state_names: tuple[str, ...] = Field((), description="names of the state's numbers, in order")
    discrete: Literal["one_hot", "number"] = Field(
        "one_hot", description="how an observation that is the number of a state is given"
    )
    aspect: float | None = Field(
        None, ge=0.2, le=5, description="width of a tile's picture over its height"
    )
    picture_width: int = Field(
        320, ge=32, le=1280, description="pictures are made smaller to at most this, pixels"
    )


def member(env_id: str) -> ModuleType:
    """Return what stands for one environment: a member of the family of tasks.

    Args:
        env_id: as it is registered; after a module and a colon if that module registers it.

    Raises:
        StudyError: Gymnasium is not installed, or no environment is registered by that id.
    """
    check_registered(env_id)
    module = ModuleType(f"{__name__}:{env_id}", __doc__)
    bound: dict[str, object] = {
        "Parameters": Parameters,
        "OUT_OF_PROCESS": OUT_OF_PROCESS,
        "describe": lambda parameters: _resolved(env_id, parameters).description,
        "create": lambda robots, parameters: GymnasiumTask(
            robots, env_id, Parameters.model_validate(parameters)
        ),
    }
    vars(module).update(bound)
    return module


def describe(parameters: Mapping[str, object] | Parameters) -> TaskDescription:  # noqa: ARG001
    """Refuse: an id is missing.

    Raises:
        StudyError: always.
    """
    raise _no_id()


def create(
    robots: int,  # noqa: ARG001 - tasks are made alike
    parameters: Mapping[str, object] | Parameters,  # noqa: ARG001
) -> GymnasiumTask:
    """Refuse: an id is missing.

    Raises:
        StudyError: always.
    """
    raise _no_id()


def _no_id() -> StudyError:
    return StudyError(
        'the task "gymnasium" names no environment',
        "Write its id after a colon, as in gymnasium:CartPole-v1.",
    )


def _resolved(env_id: str, parameters: Mapping[str, object] | Parameters) -> Resolved:
    settings = Parameters.model_validate(parameters)
    return resolve(f"gymnasium:{env_id}", env_id, settings.model_dump_json())


class GymnasiumTask:
    """A fleet of environments; a `study.tasks.base.PicturedTask`.

    Where the environment has no action of its own for a timestep without a key, the task has one
    more, its last.

    Args:
        robots: number of robots, n.
        env_id: of the environment.
        parameters: as in a protocol.

    Raises:
        StudyError: the environment cannot be a task; the message says why.
    """

    def __init__(self, robots: int, env_id: str, parameters: Parameters) -> None:
        self._resolved = _resolved(env_id, parameters)
        self.description = self._resolved.description
        self.robots = robots
        self.parameters = parameters
        self._envs = [make_environment(env_id, parameters.options) for _ in range(robots)]
        self._states = np.zeros((robots, len(self.description.state_fields)), np.float32)
        # A robot that was never reset counts as ended.
        self._outcomes = np.full(robots, Outcome.TIME_UP, np.int32)
        self._timesteps = np.zeros(robots, np.int64)
        self._pictures: npt.NDArray[np.uint8] | None = None
        self._unseen = np.ones(robots, np.bool_)

    def reset(self, mask: Mask, seeds: Seeds) -> Floats:
        """Start new episodes for the robots in ``mask`` [n]; ``seeds`` uint64 [n].

        Returns:
            States of all robots, float32 [n, d].
        """
        for robot in np.flatnonzero(mask):
            env = self._envs[robot]
            observation, _ = env.reset(seed=int(seeds[robot]))
            # Drawn from by agents that explore, never by us; some environments do, too.
            env.action_space.seed(int(seeds[robot]) % 2**32)
            self._states[robot] = row_of(env, observation, self.parameters.discrete)
            self._outcomes[robot] = _RUNNING
            self._timesteps[robot] = 0
            self._unseen[robot] = True
        return self._states.copy()

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Step the robots in ``active`` [n] that have not ended by ``actions`` int32 [n].

        Raises:
            ValueError: an active robot's action is none of the task's.
        """
        stepped = active & (self._outcomes == _RUNNING)
        known = len(self.description.action_names)
        if (actions[stepped].astype(np.uint32) >= known).any():
            raise ValueError(f"actions must be 0 to {known - 1}: {actions.tolist()}")
        rewards = np.zeros(self.robots, np.float32)
        for robot in np.flatnonzero(stepped):
            rewards[robot] = self._step(int(robot), int(actions[robot]))
        return FleetStep(self._states.copy(), rewards, self._outcomes.copy())

    def _step(self, robot: int, action: int) -> float:
        """Step one robot; return its reward."""
        env, reward = self._envs[robot], 0.0
        self._timesteps[robot] += 1
        if action == self.description.idle_action:
            action = self._resolved.without_key
        outcome = _RUNNING
        if action >= 0:
            observation, reward, terminated, truncated, _ = env.step(action)
            self._states[robot] = row_of(env, observation, self.parameters.discrete)
            self._unseen[robot] = True
            if terminated:
                meaning = self._resolved.termination
                lost = meaning == "goal_if_rewarded" and float(reward) <= 0
                outcome = _LOST if lost or meaning == "lost" else _GOAL
            elif truncated:
                outcome = _TIME_UP
        if outcome == _RUNNING and self._timesteps[robot] >= self.description.horizon:
            outcome = _TIME_UP
        self._outcomes[robot] = outcome
        return float(reward)

    def pictures(self) -> npt.NDArray[np.uint8]:
        """Return what each robot's environment shows now, uint8 [n, height, width, 3].

        Raises:
            StudyError: the environment cannot draw itself.
        """
        for robot in np.flatnonzero(self._unseen):
            picture = picture_of(self._envs[robot], self.parameters.picture_width)
            if self._pictures is None:
                self._pictures = np.zeros((self.robots, *picture.shape), np.uint8)
            self._pictures[robot] = picture
            self._unseen[robot] = False
        assert self._pictures is not None  # noqa: S101 - all are unseen at first
        return self._pictures.copy()

    def close(self) -> None:
        """Close the environments; twice is harmless."""
        for env in self._envs:
            env.close()
        self._envs = []
