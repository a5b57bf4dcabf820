"""What scorers say of recorded choices, all at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt

from study.scorers._choices import log_probabilities
from study.scorers.base import Scorer
from study.seeding import stream_seed
from study.whatif.sessions import FleetRun

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

BLOCK = 4096
"""States asked about at a time: a layer's numbers then stay in the processor's cache."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """What a scorer says of m choices.

    Attributes:
        first: int64 [m], whom it puts first, of equal scores the lower index.
        rank: int64 [m], 1 if no available robot scored higher than the one chosen.
        log_likelihood: float64 [m], of the choice by Luce's model, nats.
    """

    first: Ints
    rank: Ints
    log_likelihood: Floats


def run_scores(scorer: Scorer, runs: Sequence[FleetRun]) -> list[Floats]:
    """Return a scorer's scores of the robots at each choice of each run, float64 [m, n].

    A scorer that remembers is shown every timestep of every run from its start, runs of equal
    fleet size laid end to end as one fleet, since it keeps each robot's memory apart.
    """
    if not hasattr(scorer, "begin"):
        return [_in_blocks(scorer, run.states[run.rows]) for run in runs]
    found: dict[int, Floats] = {}
    for robots in sorted({run.states.shape[1] for run in runs}):
        places = [at for at, run in enumerate(runs) if run.states.shape[1] == robots]
        found |= zip(places, _remembering(scorer, [runs[at] for at in places]), strict=True)
    return [found[place] for place in range(len(runs))]


def _in_blocks(scorer: Scorer, states: npt.NDArray[np.float32]) -> Floats:
    flat = states.reshape(-1, states.shape[-1])
    scores = np.empty(len(flat))
    for start in range(0, len(flat), BLOCK):
        scores[start : start + BLOCK] = scorer.scores(flat[start : start + BLOCK])
    return scores.reshape(states.shape[:-1])


def _remembering(scorer: Scorer, runs: Sequence[FleetRun]) -> list[Floats]:
    robots = runs[0].states.shape[1]
    longest = max(len(run.states) for run in runs)
    begin = scorer.begin  # type: ignore[attr-defined]
    begin(robots * len(runs), stream_seed(0, "what if scorer", robots))
    every = np.empty((longest, len(runs), robots))
    for timestep in range(longest):
        # A run that is over stands still, and nobody looks at it any more.
        now = np.stack([run.states[min(timestep, len(run.states) - 1)] for run in runs])
        scores = scorer.scores(now.reshape(-1, now.shape[-1]))
        every[timestep] = scores.reshape(len(runs), robots)
    return [every[run.rows, place] for place, run in enumerate(runs)]


def judge(scores: Floats, offered: npt.NDArray[np.bool_], chosen: Ints) -> Judged:
    """Compare scores with what was chosen.

    Args:
        scores: float64 [m, n].
        offered: bool [m, n], who could be chosen; at least one in each row.
        chosen: int64 [m].
    """
    rows = np.arange(len(chosen))
    masked = np.where(offered, scores, -np.inf)
    mine = masked[rows, chosen]
    return Judged(
        first=masked.argmax(axis=1),
        rank=1 + (masked > mine[:, None]).sum(axis=1),
        log_likelihood=log_probabilities(scores, offered)[rows, chosen],
    )


def judge_runs(scorer: Scorer, runs: Sequence[FleetRun]) -> list[Judged]:
    """Return what a scorer says of the choices of each run."""
    return [
        judge(scores, run.offered, run.chosen)
        for scores, run in zip(run_scores(scorer, runs), runs, strict=True)
    ]


def judge_all(scorers: Sequence[Scorer], runs: Sequence[FleetRun]) -> list[list[Judged]]:
    """As `judge_runs` for scorers that remember nothing, on two threads.

    NumPy lets go of the interpreter while it multiplies, so threads share the work.
    """
    with ThreadPoolExecutor(max_workers=2) as pool:
        return list(pool.map(lambda scorer: judge_runs(scorer, runs), scorers))
