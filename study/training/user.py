"""Making a synthetic user: train its policy, fit its values, and say how both were made."""

from __future__ import annotations

import dataclasses
import json
import platform
from collections.abc import Callable
from importlib.metadata import version
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
import safetensors.numpy

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.families import load_member
from study.perceptron import Perceptron
from study.seeding import generator, stream_seed
from study.simulated.landmarks import Landmarks
from study.simulated.rollouts import Acting, Rollouts, roll_out
from study.simulated.trained_user import FORMAT, TrainedUser, parameters_sha256
from study.simulated.values import FittedValues, r_squared
from study.tasks.base import PlaceableTask
from study.training.soft_actor_critic import ActorCriticParameters, Spread, train
from study.training.value_fit import ValueParameters, fit_values

VALUE_TIMESTEPS = 600
"""Length of rollouts for values: at a discount of 0.99 what lies beyond counts 0.2 %."""
_PACKAGES = ("numpy", "torch", "safetensors")


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Course:
    """The task that a user is trained on.

    Attributes:
        name: of the task.
        module: of the task.
        parameters: validated, as a model of ``module.Parameters``.
        description: of the task.
        spread: draws states that a running robot can be in.
    """

    name: str
    module: ModuleType
    parameters: Any
    description: TaskDescription
    spread: Spread

    def fleet(self, robots: int, **changes: object) -> PlaceableTask:
        """Return a fleet of the task, some parameters changed."""
        parameters = self.parameters.model_copy(update=changes)
        task: PlaceableTask = self.module.create(robots, parameters)
        return task

    def given(self) -> dict[str, Any]:
        """Return all parameters, defaults filled in, as JSON would hold them."""
        dumped: dict[str, Any] = self.parameters.model_dump(mode="json")
        return dumped


def course_of(name: str, parameters: dict[str, Any]) -> Course:
    """Return the course for a task with a protocol's parameters.

    Raises:
        StudyError: robots of this task cannot be put anywhere, so that no user can be trained
            on it.
    """
    module = load_member("study.tasks", "task", name)
    settings = module.Parameters.model_validate(parameters)
    if not hasattr(module, "spread_states"):
        raise StudyError(
            f'no user can be trained on task "{name}": its robots cannot be put into any state',
            "It needs spread_states and place; see docs/how-to/train-a-user.md.",
        )

    def spread(random: np.random.Generator, count: int) -> npt.NDArray[np.float32]:
        states: npt.NDArray[np.float32] = module.spread_states(settings, random, count)
        return states

    return Course(name, module, settings, module.describe(settings), spread)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A new user: its weights' file and what was measured on the way."""

    weights: bytes
    user: TrainedUser
    values_r_squared: float


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class MeasuredValues:
    """V by Monte-Carlo: what a policy earned on average from each of some states on.

    Attributes:
        states: float32 [n, d], spread over the map.
        values: float64 [n], points.
        rollouts: that each is the mean of. One alone differs from V by the policy's own chance
            and the task's noise, and no estimate of V could explain that.
    """

    states: npt.NDArray[np.float32]
    values: npt.NDArray[np.float64]
    rollouts: int


def make_user(
    course: Course,
    training: ActorCriticParameters,
    seed: int,
    command: str,
    report: Callable[[int, float, float], None] | None = None,
) -> Made:
    """Train a user and fit its values.

    Args:
        course: the task.
        training: parameters of the training.
        seed: of all of it.
        command: that a reader would give to make the same user; kept with the weights.
        report: see `study.training.soft_actor_critic.train`.
    """
    fleet = course.fleet(training.robots, horizon=training.episode_timesteps)
    actor = train(fleet, course.spread, training, seed, report)
    landmarks = Landmarks.of(course.description)
    keys = [""] * len(course.description.action_names)
    for key, action in course.description.key_actions.items():
        keys[action] = key
    made_of: dict[str, Any] = {
        "format": FORMAT,
        "task": course.name,
        "task_version": course.description.version,
        "parameters": course.given(),
        "parameters_sha256": parameters_sha256(course.given()),
        "landmarks": landmarks.to_json(),
        "actions": list(course.description.action_names),
        "keys": keys,
        "discount": training.discount,
        "training": training.model_dump(mode="json"),
        "seed": seed,
        "command": command,
        "versions": {"python": platform.python_version()}
        | {name: version(name) for name in _PACKAGES},
    }
    nothing = Perceptron(((np.zeros((1, landmarks.size)), np.zeros(1)),))
    driver = TrainedUser(
        actor.tensors("actor") | nothing.tensors("values"), made_of, "the new user"
    )
    fitted = values_of(course, driver, training.discount, seed)
    measured = measured_values(course, driver, training.discount, seed)
    agreed = r_squared(fitted.values(measured.states), measured.values)
    made_of["values_r_squared"] = round(agreed, 4)
    made_of["values_measured"] = {"states": len(measured.states), "rollouts": measured.rollouts}
    tensors = actor.tensors("actor") | fitted.unscaled().tensors("values")
    weights = safetensors.numpy.save(tensors, {"user": json.dumps(made_of, sort_keys=True)})
    return Made(weights, TrainedUser(tensors, made_of, "the new user"), agreed)


def values_of(
    course: Course,
    driver: TrainedUser,
    discount: float,
    seed: int,
    *,
    trace: float = 1.0,
    robots: int = 4000,
) -> FittedValues:
    """Fit V of a user from rollouts that start anywhere on the map.

    Args:
        course: the task.
        driver: the user.
        discount: gamma.
        seed: of starts, noise, actions and fit.
        trace: lambda.
        robots: rollouts learned from.
    """
    rollouts = spread_rollouts(course, driver, stream_seed(seed, "value_rollouts"), robots)
    parameters = ValueParameters(discount=discount, trace=trace)
    return fit_values(rollouts, Landmarks.of(course.description), parameters, seed)


def measured_values(
    course: Course,
    driver: Acting,
    discount: float,
    seed: int,
    *,
    states: int = 400,
    rollouts: int = 25,
) -> MeasuredValues:
    """Measure V of a policy in states spread over the map.

    Args:
        course: the task.
        driver: the policy.
        discount: gamma.
        seed: of states, noise and actions.
        states: how many, n.
        rollouts: from each.
    """
    random = generator(seed, "measured_values")
    spread = course.spread(random, states)
    seeds = random.integers(0, 2**63, states * rollouts).astype(np.uint64)
    task = course.fleet(states * rollouts, horizon=VALUE_TIMESTEPS)
    driven = roll_out(task, driver, seeds, random, states=np.repeat(spread, rollouts, axis=0))
    values = driven.returns(discount)[0].reshape(states, rollouts).mean(axis=1)
    return MeasuredValues(spread, values, rollouts)


def spread_rollouts(course: Course, driver: TrainedUser, seed: int, robots: int) -> Rollouts:
    """Drive robots from anywhere on the map until they end, or as long as it counts."""
    random = generator(seed, "spread_rollouts")
    seeds = random.integers(0, 2**63, robots).astype(np.uint64)
    task = course.fleet(robots, horizon=VALUE_TIMESTEPS)
    return roll_out(task, driver, seeds, random, states=course.spread(random, robots))
