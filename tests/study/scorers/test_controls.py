"""Control scorers: nothing of the operator is in them."""

from __future__ import annotations

import numpy as np

from study.scorers import random, stuck_longest
from study.tasks import navigation

DESCRIPTION = navigation.describe({})


def states(*xs: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Robots in a row, at these places."""
    made = np.zeros((len(xs), len(DESCRIPTION.state_fields)), np.float32)
    made[:, DESCRIPTION.x_field] = xs
    return made


def test_random_repeats_by_seed_and_changes_in_time() -> None:
    """The same fleet run gets the same scores; another seed, or the next timestep, others."""
    weights = random.fit({}, DESCRIPTION, {}, 1).weights
    first, second = (random.load(weights, DESCRIPTION) for _ in range(2))
    first.begin(3, 7)
    second.begin(3, 7)
    here = states(1, 2, 3)
    one = first.scores(here)
    assert (one == second.scores(here)).all()
    assert (one != first.scores(here)).all()
    second.begin(3, 8)
    assert (one != second.scores(here)).all()


def test_the_robot_that_stays_longest_comes_first() -> None:
    """Robot 2 stays while the others go on; moving makes it start anew."""
    weights = stuck_longest.fit({}, DESCRIPTION, {"distance": 1.0}, 1).weights
    scorer = stuck_longest.load(weights, DESCRIPTION)
    scorer.begin(3, 0)
    for step in range(5):
        scores = scorer.scores(states(2.0 * step, 5.0, 2.0 * step))
    assert scores.tolist() == [0.0, 4.0, 0.0]
    assert scorer.scores(states(8.0, 9.0, 8.0)).tolist() == [1.0, 0.0, 1.0]
