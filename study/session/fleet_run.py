"""The books of one fleet run: states, episodes, rewards. No screens, no keys."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.events.inputs import FleetObserved
from study.seeding import stream_seed

_RUNNING = int(Outcome.RUNNING)


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

    Attributes:
        now: the last answer of the fleet.
        available: robots that can be chosen: those whose episode goes on, bool [n].
        restarting: robots that start anew at the next step, bool [n].
    """

    def __init__(
        self, first: FleetObserved, seed: int, starts_key: tuple[int, ...], *, restart: bool
    ) -> None:
        self._seed = seed
        self._starts_key = starts_key
        self._restart = restart
        self.robots = first.robots
        self._take(first)
        self.episodes = [1] * first.robots
        self._lengths = np.zeros(first.robots, dtype=np.int64)
        self._episode_rewards = np.zeros(first.robots)
        self._rewards = np.zeros(first.robots)

    def _take(self, observed: FleetObserved) -> None:
        self.now = observed
        self.available: npt.NDArray[np.bool_] = np.equal(observed.outcomes, _RUNNING)
        ended = ~self.available
        self.restarting = ended if self._restart else np.zeros_like(ended)

    def seeds(self) -> npt.NDArray[np.uint64]:
        """Return the seeds of the robots' next episodes, uint64 [n]; 0 where none starts."""
        seeds = np.zeros(self.robots, dtype=np.uint64)
        for robot in np.flatnonzero(self.restarting):
            seeds[robot] = self.episode_seed(int(robot), self.episodes[robot] + 1)
        return seeds

    def episode_seed(self, robot: int, episode: int) -> int:
        """Return the seed of one robot's episode."""
        return stream_seed(self._seed, "episode", *self._starts_key, robot, episode)

    def observe(self, after: FleetObserved) -> list[EndedEpisode]:
        """Take in the answer to a step; return the episodes that ended in it."""
        restarted, stepped = self.restarting, self.available
        for robot in np.flatnonzero(restarted):
            self.episodes[robot] += 1
        # Element by element in float64: the same sums on every machine.
        rewards = np.where(stepped, after.rewards, 0.0)
        self._rewards += rewards
        self._episode_rewards = np.where(restarted, 0.0, self._episode_rewards + rewards)
        self._lengths = np.where(restarted, 0, self._lengths + stepped)
        self._take(after)
        return [
            EndedEpisode(
                robot=int(robot),
                episode=self.episodes[robot],
                length=int(self._lengths[robot]),
                outcome=int(after.outcomes[robot]),
                reward=float(self._episode_rewards[robot]),
            )
            for robot in np.flatnonzero(stepped & ~self.available)
        ]

    @property
    def team_reward(self) -> float:
        """Sum of all robots' rewards so far."""
        # Not NumPy's sum: its order of adding depends on the machine.
        return float(sum(self._rewards.tolist()))
