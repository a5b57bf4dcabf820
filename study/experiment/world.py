"""One trial's world: the user, what they demonstrated, the robots' policy, and phi."""

from __future__ import annotations

import dataclasses
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from study.events.task_description import TaskDescription
from study.experiment.fleets import Fleets
from study.experiment.protocol import ExperimentProtocol, ValuesPart
from study.families import load_member
from study.policies.base import Arrays, Policy
from study.seeding import generator, stream_seed
from study.simulated.landmarks import Landmarks
from study.simulated.rollouts import Rollouts, roll_out
from study.simulated.trained_user import TrainedUser
from study.simulated.value_gain import ValueGain
from study.simulated.values import FittedValues, agreement


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Demonstrations:
    """What the user did where.

    Attributes:
        states: float32 [m, d], oldest first.
        actions: int32 [m].
    """

    states: npt.NDArray[np.float32]
    actions: npt.NDArray[np.int32]

    def arrays(self) -> Arrays:
        """Return them as a policy is fitted to them."""
        return {"states": self.states, "actions": self.actions}

    def followed_by(self, later: Demonstrations) -> Demonstrations:
        """Return these and then ``later``."""
        return Demonstrations(
            np.concatenate([self.states, later.states]),
            np.concatenate([self.actions, later.actions]),
        )


class World:
    """What all scorers of a trial share.

    Args:
        protocol: the experiment.
        seed: of this world; everything in it is keyed from it.

    Attributes:
        demonstrations: of phase one.
        user_points: float64 [episodes], what the user earned in each demonstrated episode.
        policy: fitted to the demonstrations.
        robot_values: V of that policy.
        values_r_squared: of that V against held-out rollouts.
        phi: what taking control is worth: V_user - V_robot.
    """

    def __init__(self, protocol: ExperimentProtocol, seed: int) -> None:
        self.protocol = protocol
        self.seed = seed
        self.task: ModuleType = load_member("study.tasks", "task", protocol.task.name)
        self.parameters = filled_parameters(self.task, protocol.task.parameters)
        self.description: TaskDescription = self.task.describe(self.parameters)
        self.user = TrainedUser.shipped(protocol.task.name, self.parameters)
        self.demonstrations, self.user_points = self._phase_one()
        self.policy = self.fit_policy(self.demonstrations)
        self._driven: Rollouts | None = None
        self.robot_values = self.fit_robot_values(protocol.values)
        held_out = self._robot_rollouts("held-out values", protocol.values.held_out_starts)
        self.values_r_squared = agreement(self.robot_values, held_out, self.user.discount)
        self.phi = ValueGain(self.user, self.robot_values)

    def fit_policy(self, demonstrations: Demonstrations) -> Policy:
        """Return the robots' policy, fitted to demonstrations."""
        part = self.protocol.policy
        module = load_member("study.policies", "policy", part.name)
        fitted = module.fit(
            demonstrations.arrays(), self.description, part.parameters, self.stream("policy")
        )
        policy: Policy = module.load(fitted.weights, self.description)
        return policy

    def fit_robot_values(self, values: ValuesPart) -> FittedValues:
        """Fit V of the robots' policy by TD(1).

        Called again with other units it uses the same rollouts.
        """
        # torch is slow to import, and reading the protocol needs none.
        from study.training.value_fit import ValueParameters, fit_values  # noqa: PLC0415

        if self._driven is None:
            self._driven = self._robot_rollouts("values", values.starts)
        parameters = ValueParameters(
            discount=self.user.discount,
            trace=1.0,
            hidden=values.hidden,
            rounds=1,
            epochs=values.epochs,
            batch_size=values.batch_size,
            learning_rate=values.learning_rate,
        )
        landmarks = Landmarks.of(self.description)
        return fit_values(self._driven, landmarks, parameters, self.stream("values fit"))

    def fleets(self, name: str, *, fleets: int, robots: int, paired: bool) -> Fleets:
        """Return fleets of this world; see `Fleets`."""
        return Fleets(
            self.task,
            self.parameters,
            fleets=fleets,
            robots=robots,
            seed=self.seed,
            name=name,
            paired=paired,
        )

    def stream(self, name: str, *key: int) -> int:
        """Return the seed of a named stream of this world."""
        return stream_seed(self.seed, name, *key)

    def random(self, name: str, *key: int) -> np.random.Generator:
        """Return a generator for a named stream of this world."""
        return generator(self.seed, name, *key)

    def _phase_one(self) -> tuple[Demonstrations, npt.NDArray[np.float64]]:
        episodes = self.protocol.phase_one.episodes
        driven = roll_out(
            self.task.create(episodes, self.parameters),
            self.user,
            self._seeds("phase one", episodes),
            self.random("phase one user"),
        )
        # Episode after episode, as one robot at a time would have been driven.
        kept = (driven.running & (driven.actions != self.description.idle_action)).T
        states = driven.states[:-1].transpose(1, 0, 2)
        return Demonstrations(states[kept], driven.actions.T[kept]), driven.points()

    def _robot_rollouts(self, name: str, starts: int) -> Rollouts:
        states = self.task.spread_states(self.parameters, self.random(f"{name} starts"), starts)
        return roll_out(
            self.task.create(starts, self.parameters),
            self.policy,
            self._seeds(name, starts),
            self.random(name),
            states=states,
        )

    def _seeds(self, name: str, count: int) -> npt.NDArray[np.uint64]:
        random = self.random(f"{name} episodes")
        return random.integers(2**63, size=count, dtype=np.uint64)


def filled_parameters(task: ModuleType, given: dict[str, Any]) -> dict[str, Any]:
    """Return a task's parameters with its defaults, as a trained user is checked against."""
    filled: dict[str, Any] = task.Parameters.model_validate(given).model_dump(mode="json")
    return filled
