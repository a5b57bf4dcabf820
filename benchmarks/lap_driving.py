"""Laps a minute of a simulated operator's hands, against keys at random and none, in task jetbot.

    python -m benchmarks.lap_driving [--episodes 10]

Every robot of a fleet of n is driven at every timestep, each by hands of its own that see where
the others are; so robots meet and have to avoid each other. Episodes last a minute of 8 timesteps
a second, with the motors' lag, bias and noise of the shipped protocols. What a lap takes at best is
the length of the course at full speed.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np

from study.screens import Tile
from study.seeding import generator, stream_seed
from study.simulated.laps import LapSkill, lap_parameters, lap_way
from study.simulated.parameters import draw_parameters
from study.tasks._jetbot_parameters import ACTIONS, IDLE
from study.tasks.base import Floats, Ints
from study.tasks.jetbot import create

Driving = Callable[[Floats], Ints]
RATE = 8.0


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Laps a minute and robot.")
    parser.add_argument("--episodes", type=int, default=10)
    episodes = parser.parse_args().episodes
    task = create(1, {"timesteps_per_second": RATE})
    period = lap_way(task.description.scene).period
    print(f"course {period:.2f} m, {period / 0.25:.1f} s a lap at full speed without a turn")
    print("robots   operator   uniform random   idle   (laps a minute and robot, mean)")
    for robots in (1, 2, 3):
        found = [
            np.mean([laps(robots, seed, driving) for seed in range(episodes)])
            for driving in (operator, uniform_random, idle)
        ]
        print(f"{robots:6d}   {found[0]:8.2f}   {found[1]:14.2f}   {found[2]:4.2f}")


def laps(robots: int, seed: int, driving: Callable[[int, int], Driving]) -> float:
    """Return the laps a robot of one episode."""
    task = create(robots, {"timesteps_per_second": RATE})
    everybody = np.ones(robots, np.bool_)
    seeds = [stream_seed(seed, "lap_driving", robot) for robot in range(robots)]
    states = task.reset(everybody, np.array(seeds, np.uint64))
    act, total = driving(robots, seed), 0.0
    for _ in range(task.description.horizon):
        stepped = task.step(act(states), everybody)
        states, total = stepped.states, total + float(stepped.rewards.sum())
    task.close()
    return total / robots


def operator(robots: int, seed: int) -> Driving:
    """Return hands for each robot."""
    scene = create(1, {}).description.scene
    parameters = lap_parameters(draw_parameters(seed, 0))
    skills = [LapSkill(parameters, generator(seed, "hands", robot)) for robot in range(robots)]
    keys = {"up": 0, "down": 1, "left": 2, "right": 3, "": IDLE}

    def act(states: Floats) -> Ints:
        tiles = tuple(
            Tile(robot, *map(float, state[:3]), health=100.0, cue=None, episode=1)
            for robot, state in enumerate(states)
        )
        chosen = []
        for robot, skill in enumerate(skills):
            skill.look(scene, tiles, robot)
            chosen.append(keys[skill.key(tiles[robot])])
        return np.array(chosen, np.int32)

    return act


def uniform_random(robots: int, seed: int) -> Driving:
    """Return a policy that presses any key at every timestep."""
    random = generator(seed, "uniform_random")
    return lambda _: random.integers(0, len(ACTIONS), robots).astype(np.int32)


def idle(robots: int, seed: int) -> Driving:
    """Return a policy that does nothing."""
    del seed
    return lambda _: np.full(robots, IDLE, np.int32)


if __name__ == "__main__":
    main()
