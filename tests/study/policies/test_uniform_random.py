"""The policy that robots start with."""

from __future__ import annotations

import numpy as np

from study.policies import uniform_random
from study.tasks import navigation


def test_all_actions_but_idling_are_equally_likely() -> None:
    """Of 20,000 draws each action gets its share and idling none."""
    policy = uniform_random.create(navigation.describe({}))
    drawn = policy.actions(np.zeros((20_000, 4), np.float32), np.random.default_rng(1))
    counts = np.bincount(drawn, minlength=5)
    assert counts[navigation.IDLE] == 0
    assert np.abs(counts[:4] - 5000).max() < 300


def test_the_stream_decides() -> None:
    """Equal streams give equal actions."""
    policy = uniform_random.create(navigation.describe({}))
    states = np.zeros((50, 4), np.float32)
    first, second = (policy.actions(states, np.random.default_rng(5)) for _ in range(2))
    assert first.tolist() == second.tolist()
