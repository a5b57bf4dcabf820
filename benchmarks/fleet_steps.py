"""Fleet steps a second: our batch against Gymnasium's SyncVectorEnv of the same task.

python -m benchmarks.fleet_steps [--quick]

The alternative is what Gymnasium's users would do: one environment a robot, each holding the
navigation task with a single robot, stepped in turn by SyncVectorEnv. Both are given the same
seeds and actions, and every state must agree to the last bit. A fleet step steps all n robots.
Resets are not timed: no episode ends within the timesteps measured.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.growth import print_growth, print_row, versions
from benchmarks.made_up_sessions import machine
from study.seeding import generator
from study.tasks import navigation

TARGET = 100
CHANCES = (0.5, 0.1, 0.15, 0.15, 0.1)

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode, SyncVectorEnv
except ImportError:
    print("gymnasium is not installed: pip install --group benchmarks")
    sys.exit(1)


class NavigationEnv(gymnasium.Env):  # type: ignore[type-arg, misc]
    """One robot of the navigation task as a Gymnasium environment."""

    def __init__(self) -> None:
        self._task = navigation.create(1, {"horizon": 100_000, "hazard_damage": 0.0})
        fields = self._task.description.state_fields
        self.observation_space = gymnasium.spaces.Box(
            np.array([field.low for field in fields], np.float32),
            np.array([field.high for field in fields], np.float32),
        )
        self.action_space = gymnasium.spaces.Discrete(len(self._task.description.action_names))
        self._active = np.ones(1, np.bool_)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Start an episode from a seed."""
        del options
        return self._task.reset(self._active, np.array([seed or 0], np.uint64))[0], {}

    def step(
        self, action: int
    ) -> tuple[npt.NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Take one timestep."""
        step = self._task.step(np.array([action], np.int32), self._active)
        ended = bool(step.outcomes[0] != 0)
        return step.states[0], float(step.rewards[0]), ended, False, {}


def timed(robots: int, timesteps: int) -> tuple[float, float]:
    """Return the median time of a fleet step, s: ours and Gymnasium's."""
    seeds = np.arange(robots, dtype=np.uint64)
    random = generator(1, "benchmark_actions", robots)
    actions = random.choice(5, (timesteps, robots), p=CHANCES).astype(np.int32)
    every = np.ones(robots, np.bool_)
    short = {"horizon": timesteps + 1, "hazard_damage": 0.0}

    class ShortEnv(NavigationEnv):
        def __init__(self) -> None:
            super().__init__()
            self._task = navigation.create(1, short)

    ours = navigation.create(robots, short)
    theirs = SyncVectorEnv([ShortEnv] * robots, autoreset_mode=AutoresetMode.DISABLED)
    states = ours.reset(every, seeds)
    others, _ = theirs.reset(seed=[int(seed) for seed in seeds])
    assert (states == others).all()
    mine, their = [], []
    for chosen in actions:
        begun = time.perf_counter()
        step = ours.step(chosen, every)
        between = time.perf_counter()
        others, rewards, *_ = theirs.step(chosen)
        done = time.perf_counter()
        mine.append(between - begun)
        their.append(done - between)
        assert step.states.tobytes() == others.tobytes()
        assert (step.rewards == rewards.astype(np.float32)).all()
        if (step.outcomes != 0).any():
            break
    return float(np.median(mine)), float(np.median(their))


def main() -> None:
    """Measure and print."""
    sizes = [1, 12, 100, 1000] if "--quick" in sys.argv else [1, 4, 12, 50, 200, 1000, 4000]
    print(machine())
    print(versions("numpy", "gymnasium"))
    print("One step of n robots, equal to the last bit:")
    times: dict[str, list[float]] = {"ours": [], "SyncVectorEnv": []}
    for size in sizes:
        mine, theirs = timed(size, 20 if size >= 1000 else 60)
        times["ours"].append(mine)
        times["SyncVectorEnv"].append(theirs)
        print_row(f"{size:,}", mine, {"SyncVectorEnv": theirs})
        print(
            f"{'':17s}fleet steps a second: ours {1 / mine:,.0f}, SyncVectorEnv {1 / theirs:,.1f}"
        )
    at = sizes.index(1000)
    ratio = times["SyncVectorEnv"][at] / times["ours"][at]
    word = "reached" if ratio >= TARGET else "not reached"
    print(f"At n=1000 ours is {ratio:.0f} times as fast; the target of {TARGET} is {word}.")
    print("Growth with the number of robots:")
    print_growth(sizes, times)


if __name__ == "__main__":
    main()
