"""The books of one fleet run: states, episodes, rewards. No screens, no keys."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.events.inputs import FleetObserved
from study.seeding import stream_seed


@dataclasses.dataclass(frozen=True, slots=True)
class EndedEpisode:
    """An episode that ended in the last step."""

    robot: int
    episode: int
    length: int
    outcome: int
    reward: float


class FleetRun:
    """Keeps what happened to each robot between start and end of a trial.

    Args:
        first: the answer to StartFleet.
        seed: the session's seed.
        starts_key: numbers that key the start states of this run.
        restart: whether a robot that ended starts anew at the next timestep.
    """

    def __init__(
        self, first: FleetObserved, seed: int, starts_key: tuple[int, ...], *, restart: bool
    ) -> None:
        self._seed = seed
        self._starts_key = starts_key
        self._restart = restart
        self.now = first
        self.robots = first.robots
        self.episodes = [1] * first.robots
        self._lengths = [0] * first.robots
        self._episode_rewards: list[list[float]] = [[] for _ in range(first.robots)]
        self._rewards: list[float] = []

    @property
    def available(self) -> npt.NDArray[np.bool_]:
        """Robots that can be chosen: those whose episode goes on, [n]."""
        return np.equal(self.now.outcomes, Outcome.RUNNING.value)

    @property
    def restarting(self) -> npt.NDArray[np.bool_]:
        """Robots that start anew at the next step, [n]."""
        return ~self.available if self._restart else np.zeros(self.robots, dtype=np.bool_)

    def seeds(self) -> npt.NDArray[np.uint64]:
        """Return the seeds of the robots' next episodes, uint64 [n]; 0 where none starts."""
        return np.array(
            [
                self.episode_seed(robot, self.episodes[robot] + 1) if restarts else 0
                for robot, restarts in enumerate(self.restarting)
            ],
            dtype=np.uint64,
        )

    def episode_seed(self, robot: int, episode: int) -> int:
        """Return the seed of one robot's episode."""
        return stream_seed(self._seed, "episode", *self._starts_key, robot, episode)

    def observe(self, after: FleetObserved) -> list[EndedEpisode]:
        """Take in the answer to a step; return the episodes that ended in it."""
        restarted = self.restarting
        stepped = self.available
        ended: list[EndedEpisode] = []
        for robot in range(self.robots):
            if restarted[robot]:
                self.episodes[robot] += 1
                self._lengths[robot] = 0
                self._episode_rewards[robot] = []
            elif stepped[robot]:
                reward = float(after.rewards[robot])
                self._lengths[robot] += 1
                self._episode_rewards[robot].append(reward)
                self._rewards.append(reward)
                if after.outcomes[robot] != Outcome.RUNNING:
                    ended.append(
                        EndedEpisode(
                            robot=robot,
                            episode=self.episodes[robot],
                            length=self._lengths[robot],
                            outcome=int(after.outcomes[robot]),
                            reward=math.fsum(self._episode_rewards[robot]),
                        )
                    )
        self.now = after
        return ended

    @property
    def team_reward(self) -> float:
        """Sum of all rewards so far, correctly rounded, so that it is the same everywhere."""
        return math.fsum(self._rewards)
