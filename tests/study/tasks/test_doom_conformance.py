"""DOOM against NumPy: the same starts and actions, 600 tics, packs and hazards included."""

from __future__ import annotations

import hashlib
import subprocess
import sys

import numpy as np
import numpy.typing as npt
import pytest

from extras import need
from study.events.codes import Outcome
from study.layouts import named_layout
from study.tasks import doom, navigation
from study.tasks.doom import DoomTask
from study.tasks.navigation import BACKWARD, FORWARD, TURN_LEFT, NavigationTask
from study.terrain import Terrain

need("vizdoom")

ROBOTS = 12
TIMESTEPS = 150
"""600 tics."""
EVERY = np.ones(ROBOTS, np.bool_)
TERRAIN = Terrain(named_layout("three_rooms"))
CHANCES = (0.6, 0.1, 0.12, 0.12, 0.06)

FREE_METRES = 0.02
"""How far the two worlds may be apart after 600 tics in which no wall was touched."""

WALL_METRES = 0.6
"""The same with walls: navigation stops up to a timestep's way (0.5 m) short of them."""

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.bool_]


def _worlds(**parameters: object) -> tuple[DoomTask, NavigationTask]:
    settings = {"horizon": 1000, "noise": 0.0, **parameters}
    seen = {"frames": "last"}
    return doom.create(ROBOTS, settings | seen), navigation.create(ROBOTS, settings)


def _start(first: DoomTask, second: NavigationTask, states: npt.NDArray[np.float32]) -> None:
    """Start all robots of both worlds in the same states."""
    seeds = np.arange(ROBOTS, dtype=np.uint64)
    first.reset(EVERY, seeds)
    second.reset(EVERY, seeds)
    assert second.place(EVERY, first.place(EVERY, states)) is not None


def _ambiguous(x: Floats, y: Floats) -> Places:
    """Say where centimetres decide: at the edge of a hazard, a pack or the goal, at a wall."""
    near = 0.1
    steps = np.array([(a, b) for a in (-near, 0, near) for b in (-near, 0, near)]).T
    xs, ys = x + steps[0][:, None], y + steps[1][:, None]
    unclear = ~TERRAIN.is_legal(xs, ys).all(axis=0)
    for ask in (TERRAIN.in_hazard, TERRAIN.at_pack, TERRAIN.at_goal):
        inside = ask(xs, ys)
        unclear |= inside.any(axis=0) & ~inside.all(axis=0)
    return np.asarray(unclear)


def _careful(
    states: npt.NDArray[np.float32], actions: npt.NDArray[np.int32]
) -> npt.NDArray[np.int32]:
    """Turn instead where a way would touch a wall or end where centimetres decide."""
    x, y, heading, _ = states.astype(np.float64).T
    way = np.select([actions == FORWARD, actions == BACKWARD], [0.5, -0.3], 0.0)
    unclear = _ambiguous(x + way * np.cos(heading), y + way * np.sin(heading))
    return np.where(unclear & (way != 0), TURN_LEFT, actions).astype(np.int32)


def _apart(first: npt.NDArray[np.float32], second: npt.NDArray[np.float32]) -> Floats:
    between = (first - second).astype(np.float64)
    return np.hypot(between[:, 0], between[:, 1])


def test_free_driving_agrees_health_to_the_last_bit() -> None:
    """Without walls: centimetres after 600 tics, equal headings, damage, healing and outcomes."""
    first, second = _worlds(hazard_damage=2.0)
    random = np.random.default_rng(3)
    worst, hurt, healed, ended = [], 0, 0, 0
    for _ in range(5):
        states = second.dynamics.spread_states(random, 400)
        clear = ~_ambiguous(states[:, 0].astype(np.float64), states[:, 1].astype(np.float64))
        _start(first, second, states[clear][:ROBOTS])
        here = second.reset(np.zeros(ROBOTS, np.bool_), np.zeros(ROBOTS, np.uint64))
        for _ in range(TIMESTEPS):
            drawn = random.choice(5, ROBOTS, p=CHANCES).astype(np.int32)
            actions = _careful(here, drawn)
            mine, theirs = first.step(actions, EVERY), second.step(actions, EVERY)
            assert (mine.states[:, 2] == theirs.states[:, 2]).all()
            assert np.allclose(mine.states[:, 3], theirs.states[:, 3], atol=1e-4)
            assert mine.outcomes.tolist() == theirs.outcomes.tolist()
            assert np.allclose(mine.rewards, theirs.rewards, atol=FREE_METRES)
            hurt += int((theirs.states[:, 3] < here[:, 3]).sum())
            healed += int((theirs.states[:, 3] > here[:, 3]).sum())
            here = theirs.states
        worst.append(_apart(mine.states, theirs.states))
        ended += int((mine.outcomes != Outcome.RUNNING).sum())
    first.close()
    apart = np.concatenate(worst)
    print(  # noqa: T201 - the figures of the documentation, with pytest -s
        f"\n{apart.size} robots, 600 tics, no wall touched: apart by median "
        f"{np.median(apart):.4f} m, at most {apart.max():.4f} m; {hurt} timesteps in hazards, "
        f"{healed} healed, {ended} ended"
    )
    assert apart.max() <= FREE_METRES
    assert hurt > 100
    assert healed >= 40
    assert ended > 5


def test_random_driving_into_walls_agrees_within_a_timesteps_way() -> None:
    """Walls included: no robot is further apart than a timestep's way and a little."""
    first, second = _worlds(hazard_damage=0.0, pack_heal=0.0)
    worst = []
    for seed in range(3):
        random = np.random.default_rng(seed)
        states = second.dynamics.spread_states(random, ROBOTS)
        _start(first, second, states)
        for _ in range(TIMESTEPS):
            actions = random.choice(5, ROBOTS, p=CHANCES).astype(np.int32)
            mine, theirs = first.step(actions, EVERY), second.step(actions, EVERY)
            worst.append(_apart(mine.states, theirs.states))
    first.close()
    apart = np.array(worst)
    ends = apart[TIMESTEPS - 1 :: TIMESTEPS]
    print(  # noqa: T201 - the figures of the documentation, with pytest -s
        f"\n{ends.size} robots, 600 tics, walls touched: apart by median "
        f"{np.median(ends):.3f} m at the end, at most {apart.max():.3f} m ever"
    )
    assert apart.max() <= WALL_METRES


_RUN = """
import hashlib, sys
import numpy as np
from study.tasks import doom
task = doom.create(3, {"workers": int(sys.argv[1]), "motion": sys.argv[2]})
every = np.ones(3, np.bool_)
digest = hashlib.sha256(task.reset(every, np.arange(3, dtype=np.uint64)).tobytes())
random = np.random.default_rng(5)
for _ in range(100):
    step = task.step(random.integers(0, 5, 3).astype(np.int32), every)
    for array in (step.states, step.rewards, step.outcomes, *map(task.frames, range(4))):
        digest.update(np.ascontiguousarray(array).tobytes())
task.close()
print(digest.hexdigest())
"""


@pytest.mark.parametrize("motion", ["exact", "stock"])
def test_same_seed_and_actions_give_the_same_bits_in_any_process(motion: str) -> None:
    """States, rewards and all pictures are equal, however many workers there are."""
    digests = {
        subprocess.run(
            [sys.executable, "-c", _RUN, workers, motion],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for workers in ("1", "3")
    }
    assert len(digests) == 1
    assert len(digests.pop().strip()) == len(hashlib.sha256().hexdigest())
