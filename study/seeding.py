"""Random streams, each keyed by what it is for: resuming needs no generator's state."""

from __future__ import annotations

import hashlib

import numpy as np


def stream_key(seed: int, name: str, *key: int) -> np.random.SeedSequence:
    """Return the seed sequence of one named stream.

    Args:
        seed: the session's seed, 0 to 2**64 - 1.
        name: what the stream is for.
        key: phase, block, trial, robot, episode: whatever tells it from its like.
    """
    digest = hashlib.sha256(name.encode()).digest()
    words = [int.from_bytes(digest[i : i + 4], "little") for i in range(0, 8, 4)]
    return np.random.SeedSequence(entropy=seed, spawn_key=(*words, *key))


def stream_seed(seed: int, name: str, *key: int) -> int:
    """Return one 63-bit number from the named stream, to hand across a boundary."""
    word = stream_key(seed, name, *key).generate_state(1, np.uint64)[0]
    return int(word) >> 1


def generator(seed: int, name: str, *key: int) -> np.random.Generator:
    """Return a generator for the named stream."""
    return np.random.Generator(np.random.PCG64(stream_key(seed, name, *key)))
