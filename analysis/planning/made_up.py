"""Made-up studies whose truth is known: every trial of many studies at once.

The law is that of `benchmarks.simulated_designs`: levels, true differences between people, noise,
what order adds; and what is lost.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.planning.assumptions import Assumptions, Design
from study.seeding import generator

BLOCK = 50
"""Studies that share a random stream: which study is which hangs on no number of workers."""


@dataclasses.dataclass(frozen=True, slots=True)
class MadeUp:
    """Some studies of one design.

    Attributes:
        rewards: team reward of every trial as if none were lost, shape (studies, participants,
            conditions, trials).
        there: which of them there are, same shape.
        places: place of each condition in each participant's session, shape (participants,
            conditions).
    """

    rewards: npt.NDArray[np.float64]
    there: npt.NDArray[np.bool_]
    places: npt.NDArray[np.int64]

    def frame(self, study: int) -> pd.DataFrame:
        """Return the trials of one study as the analysis has them, those lost left out."""
        person, condition, trial = np.nonzero(self.there[study])
        return pd.DataFrame(
            {
                "participant": [f"P{number:04d}" for number in person],
                "condition": [level_names(self.places.shape[1])[each] for each in condition],
                "block": self.places[person, condition] + 1,
                "trial": trial + 1,
                "team_reward": self.rewards[study][person, condition, trial],
            }
        )


def level_names(conditions: int) -> tuple[str, ...]:
    """Return names for made-up conditions, the reference first."""
    return tuple(f"C{number:02d}" for number in range(conditions))


def make_up(given: Assumptions, design: Design, seed: int, stream: str, block: int) -> MadeUp:
    """Draw a block of studies, the same for the same arguments.

    What is lost is drawn last, so that studies with and without losses share all else.

    Args:
        given: their law.
        design: their size.
        seed: of the plan.
        stream: what they are for.
        block: which of them, from 0.
    """
    n, c, k = design.participants, given.conditions, design.trials
    random = generator(seed, f"plan {stream}", n, k, block)
    levels = given.level_sd * random.standard_normal((BLOCK, n, 1, 1))
    own = given.effect_sd / np.sqrt(2) * random.standard_normal((BLOCK, n, c, 1))
    noise = given.trial_sd * random.standard_normal((BLOCK, n, c, k))
    turn = np.arange(n) % len(given.orders)
    order = (given.shifts()[turn] + np.array(given.effects))[None, :, :, None]
    rewards = levels + own + noise + order + given.learning * np.arange(k)
    places = np.argsort(np.array(given.orders), axis=1)[turn]
    there = np.ones(rewards.shape, dtype=bool)
    if given.drop_out:
        leaves = random.random((BLOCK, n)) < given.drop_out
        last = np.where(leaves, random.integers(0, c * k, (BLOCK, n)), c * k)
        number = places[:, :, None] * k + np.arange(k)
        there &= number[None] < last[:, :, None, None]
    if given.missing:
        there &= random.random(rewards.shape) >= given.missing
    if needed := given.trials_needed(k):
        there &= (there.sum(axis=(2, 3)) >= needed)[:, :, None, None]
    return MadeUp(rewards, there, places)
