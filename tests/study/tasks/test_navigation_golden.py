"""Navigation's numbers never change: recordings are stepped anew to prove what happened."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from study.tasks import navigation

GOLDEN: dict[str, tuple[dict[str, object], str]] = {
    "as shipped": ({}, "4d22a51ef4f6c4533dd2f675c2d18e46672453669ed35d220b4500acc0edae43"),
    "noisy, short and costly": (
        {"noise": 0.06, "horizon": 60, "forward": 0.35, "hazard_damage": 11.0, "pack_heal": 3.3},
        "cc5b9604b81e01770343fbb90514c1d6c1bab88334c7dc306aef09520340abfc",
    ),
}


def _digest(parameters: dict[str, object], robots: int, timesteps: int) -> str:
    """Hash all that a fleet returns while it is driven at random and ended robots start anew."""
    random = np.random.Generator(np.random.PCG64(20))
    task = navigation.create(robots, parameters)
    every = np.ones(robots, np.bool_)
    digest = hashlib.sha256(task.reset(every, np.arange(robots, dtype=np.uint64)).tobytes())
    # Mostly forwards, as driven: corners, doors, hazards, packs and the goal are all met.
    chances = [0.72, 0.06, 0.1, 0.1, 0.02]
    for timestep in range(timesteps):
        actions = random.choice(5, robots, p=chances).astype(np.int32)
        step = task.step(actions, random.random(robots) < 0.95)
        for array in (step.states, step.rewards, step.outcomes):
            digest.update(array.tobytes())
        ended = step.outcomes != 0
        seeds = np.arange(robots, dtype=np.uint64) + np.uint64(robots * (timestep + 1))
        digest.update(task.reset(ended, seeds).tobytes())
    return digest.hexdigest()


@pytest.mark.parametrize("name", GOLDEN)
def test_every_bit_is_as_it_was(name: str) -> None:
    """States, rewards and outcomes of a long drive are the recorded ones."""
    parameters, expected = GOLDEN[name]
    assert _digest(parameters, 300, 400) == expected
