"""Discrete soft actor-critic on a fleet of task robots.

Haarnoja et al. (2018) with the expectation over actions taken exactly (Christodoulou, 2019):
the critics give Q for every action, so neither a sampled action nor a reparameterisation is
needed. The temperature is fixed: the user's noise is a setting, not something to be learned.
The task's horizon is no end to the user, who knows no clock: where time is up, what would have
followed counts. Only goal and loss end a return.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import torch
from pydantic import BaseModel, ConfigDict, Field

from study.events.codes import Outcome
from study.perceptron import Perceptron
from study.seeding import generator, stream_seed
from study.simulated.landmarks import Landmarks
from study.tasks.base import PlaceableTask

States = npt.NDArray[np.float32]
Spread = Callable[[np.random.Generator, int], States]
"""Draws states that a running robot can be in: float32 [count, d]."""


class ActorCriticParameters(BaseModel):
    """How the user is trained."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    hidden: tuple[int, ...] = Field((256, 256), description="units of each hidden ReLU layer")
    temperature: float = Field(0.05, gt=0, description="alpha, points per nat of entropy")
    discount: float = Field(0.99, gt=0, lt=1, description="gamma, per timestep")
    updates: int = Field(80_000, ge=1, description="gradient steps")
    robots: int = Field(64, ge=2, description="robots that gather experience side by side")
    updates_a_timestep: int = Field(2, ge=1, description="gradient steps for each fleet timestep")
    episode_timesteps: int = Field(
        40, ge=1, description="timesteps after which a robot starts anew; to learning no end"
    )
    spread_starts: float = Field(
        0.8, ge=0, le=1, description="part of the episodes that start anywhere on the map"
    )
    memory: int = Field(400_000, ge=1, description="transitions kept")
    batch_size: int = Field(256, ge=1, description="transitions in a minibatch")
    learning_rate: float = Field(0.001, gt=0, description="Adam's step size at the start")
    averaging: float = Field(0.01, gt=0, le=1, description="target critics' step to the critics")
    first_timesteps: int = Field(200, ge=1, description="fleet timesteps driven at random first")


class TwinCritics(torch.nn.Module):
    """Two independent networks, computed in one batched product: features to Q of each action."""

    def __init__(self, widths: tuple[int, ...]) -> None:
        super().__init__()
        self.weights = torch.nn.ParameterList()
        self.biases = torch.nn.ParameterList()
        for before, after in itertools.pairwise(widths):
            limit = 1 / math.sqrt(before)
            self.weights.append(
                torch.nn.Parameter(torch.empty(2, before, after).uniform_(-limit, limit))
            )
            self.biases.append(torch.nn.Parameter(torch.empty(2, 1, after).uniform_(-limit, limit)))

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        """Return Q [2, b, actions] for features [b, k]."""
        values = features.expand(2, *features.shape)
        last = len(self.weights) - 1
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = torch.baddbmm(bias, values, weight)
            if number < last:
                values = torch.relu(values)
        return values


class Memory:
    """The latest transitions, as features; the oldest are overwritten."""

    def __init__(self, size: int, width: int) -> None:
        self._now = np.zeros((size, width), np.float32)
        self._next = np.zeros((size, width), np.float32)
        self._actions = np.zeros(size, np.int64)
        self._rewards = np.zeros(size, np.float32)
        self._goes_on = np.zeros(size, np.float32)
        self._added = 0

    def add(
        self,
        now: npt.NDArray[np.floating],
        actions: npt.NDArray[np.int32],
        rewards: npt.NDArray[np.float32],
        following: npt.NDArray[np.floating],
        goes_on: npt.NDArray[np.bool_],
    ) -> None:
        """Keep k transitions."""
        rows = (self._added + np.arange(len(actions))) % len(self._actions)
        self._now[rows], self._next[rows] = now, following
        self._actions[rows], self._rewards[rows], self._goes_on[rows] = actions, rewards, goes_on
        self._added += len(actions)

    def draw(self, count: int, random: np.random.Generator) -> tuple[torch.Tensor, ...]:
        """Draw a minibatch: now, actions, rewards, next, whether it goes on."""
        rows = random.integers(0, min(self._added, len(self._actions)), count)
        arrays = (self._now, self._actions, self._rewards, self._next, self._goes_on)
        return tuple(torch.from_numpy(array[rows]) for array in arrays)


class Learner:
    """Actor, critics and their optimisers.

    Attributes:
        actor: features [b, k] to logits [b, actions].
        critics: features [b, k] to Q [2, b, actions].
    """

    def __init__(self, inputs: int, actions: int, parameters: ActorCriticParameters) -> None:
        self._parameters = parameters
        widths = (inputs, *parameters.hidden, actions)
        parts: list[torch.nn.Module] = []
        for before, after in itertools.pairwise(widths):
            parts += [torch.nn.Linear(before, after), torch.nn.ReLU()]
        self.actor = torch.nn.Sequential(*parts[:-1])
        self.critics, self._targets = TwinCritics(widths), TwinCritics(widths)
        self._targets.load_state_dict(self.critics.state_dict())
        rate = parameters.learning_rate
        self._optimisers = [
            torch.optim.Adam(self.actor.parameters(), lr=rate, fused=True),
            torch.optim.Adam(self.critics.parameters(), lr=rate, fused=True),
        ]

    def update(self, batch: tuple[torch.Tensor, ...], falling: float) -> tuple[float, float]:
        """Take one gradient step; return the critics' loss and the policy's entropy, nats."""
        parameters = self._parameters
        for optimiser in self._optimisers:
            optimiser.param_groups[0]["lr"] = parameters.learning_rate * falling
        now, actions, rewards, following, goes_on = batch
        with torch.no_grad():
            logs = self.actor(following).log_softmax(dim=1)
            ahead = self._targets(following).amin(dim=0) - parameters.temperature * logs
            wanted = rewards + parameters.discount * goes_on * (logs.exp() * ahead).sum(dim=1)
        q = self.critics(now)
        taken = q.gather(2, actions[None, :, None].expand(2, -1, -1))[:, :, 0]
        critic_loss = 2 * torch.nn.functional.mse_loss(taken, wanted.expand(2, -1))
        logs = self.actor(now).log_softmax(dim=1)
        chances = logs.exp()
        least = q.detach().amin(dim=0)
        actor_loss = (chances * (parameters.temperature * logs - least)).sum(dim=1).mean()
        for optimiser in self._optimisers:
            optimiser.zero_grad()
        (critic_loss + actor_loss).backward()
        for optimiser in self._optimisers:
            optimiser.step()
        with torch.no_grad():
            pairs = zip(self._targets.parameters(), self.critics.parameters(), strict=True)
            for target, critic in pairs:
                target.lerp_(critic, parameters.averaging)
            entropy = -(chances * logs).sum(dim=1).mean()
        return float(critic_loss.detach()), float(entropy)

    def act(
        self, features: npt.NDArray[np.floating], random: np.random.Generator
    ) -> npt.NDArray[np.int32]:
        """Draw an action for each row of features [n, k]."""
        with torch.no_grad():
            chances = self.actor(torch.from_numpy(features).float()).softmax(dim=1).double().numpy()
        upto = chances.cumsum(axis=1)
        marks = random.random(len(upto))[:, None] * upto[:, -1:]
        drawn: npt.NDArray[np.int32] = (marks >= upto[:, :-1]).sum(axis=1).astype(np.int32)
        return drawn

    def policy(self) -> Perceptron:
        """Return the actor as arrays."""
        return Perceptron(
            tuple(
                (part.weight.detach().double().numpy(), part.bias.detach().double().numpy())
                for part in self.actor
                if isinstance(part, torch.nn.Linear)
            )
        )


class Experience:
    """The fleet that gathers transitions, and starts anew where an episode ends."""

    def __init__(
        self, task: PlaceableTask, spread: Spread, parameters: ActorCriticParameters, seed: int
    ) -> None:
        self._task, self._spread, self._parameters = task, spread, parameters
        self._seed = seed
        self._landmarks = Landmarks.of(task.description)
        self._random = generator(seed, "experience")
        self._episodes = 0
        self._every = np.ones(task.robots, np.bool_)
        self._states = np.zeros((task.robots, len(task.description.state_fields)), np.float32)
        self._finished: list[float] = []
        self._points = np.zeros(task.robots)
        self._begin(self._every)

    def features(self, states: States) -> npt.NDArray[np.float64]:
        """Return the features [n, k] of states."""
        return self._landmarks.features(states)

    def gather(self, learner: Learner | None, memory: Memory) -> None:
        """Drive one timestep, at random without a learner, and remember it."""
        now = self.features(self._states)
        if learner is None:
            count = len(self._task.description.action_names)
            actions = self._random.integers(0, count, self._task.robots).astype(np.int32)
        else:
            actions = learner.act(now, self._random)
        step = self._task.step(actions, self._every)
        goes_on = ~np.isin(step.outcomes, (Outcome.GOAL, Outcome.LOST))
        memory.add(now, actions, step.rewards, self.features(step.states), goes_on)
        self._states = step.states
        self._points += step.rewards
        ended = step.outcomes != Outcome.RUNNING
        if ended.any():
            self._finished += self._points[ended].tolist()
            self._begin(ended)

    def recent_points(self) -> float:
        """Return the mean points of the latest 500 episodes, cut off as they are."""
        return float(np.mean(self._finished[-500:])) if self._finished else math.nan

    def _begin(self, mask: npt.NDArray[np.bool_]) -> None:
        robots = self._task.robots
        seeds = np.zeros(robots, np.uint64)
        for robot in np.flatnonzero(mask):
            seeds[robot] = stream_seed(self._seed, "episode", self._episodes)
            self._episodes += 1
        self._states = self._task.reset(mask, seeds)
        spread = mask & (self._random.random(robots) < self._parameters.spread_starts)
        if spread.any():
            placed = self._states.copy()
            placed[spread] = self._spread(self._random, int(spread.sum()))
            self._states = self._task.place(spread, placed)
        self._points[mask] = 0.0


def train(
    task: PlaceableTask,
    spread: Spread,
    parameters: ActorCriticParameters,
    seed: int,
    report: Callable[[int, float, float], None] | None = None,
) -> Perceptron:
    """Train a policy; return its network, features (see `study.simulated.landmarks`) to logits.

    Args:
        task: a fleet of ``parameters.robots`` robots whose horizon is
            ``parameters.episode_timesteps``.
        spread: draws the starts of those episodes that begin anywhere.
        parameters: of the training.
        seed: of weights, starts, noise, actions and minibatches.
        report: called every 500 updates with updates done, points of recent episodes, entropy.
    """
    torch.set_num_threads(1)
    experience = Experience(task, spread, parameters, seed)
    inputs = experience.features(np.zeros((1, len(task.description.state_fields)), np.float32))
    random = generator(seed, "minibatches")
    memory = Memory(parameters.memory, inputs.shape[1])
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(stream_seed(seed, "weights"))
        learner = Learner(inputs.shape[1], len(task.description.action_names), parameters)
    for _ in range(parameters.first_timesteps):
        experience.gather(None, memory)
    for done in range(parameters.updates):
        if done % parameters.updates_a_timestep == 0:
            experience.gather(learner, memory)
        # Large steps first; the last half falls to a tenth, where the policy settles.
        part = max(0.0, 2 * done / parameters.updates - 1)
        falling = 0.1 + 0.9 * 0.5 * (1 + math.cos(math.pi * part))
        _, entropy = learner.update(memory.draw(parameters.batch_size, random), falling)
        if report is not None and (done + 1) % 500 == 0:
            report(done + 1, experience.recent_points(), entropy)
    return learner.policy()
