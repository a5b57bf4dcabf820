"""Power by simulation: pieces for workers, and what they add up to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.closed_form import ClosedForm, closed_form
from analysis.planning.made_up import BLOCK, make_up
from analysis.planning.testing import analyse_many
from analysis.statistics.proportion import wilson
from analysis.statistics.result import Interval

QUICK_BLOCKS = 20
"""Blocks that a worker takes at once where the test is that of means."""


@dataclasses.dataclass(frozen=True, slots=True)
class Counts:
    """What came of some made-up studies.

    Attributes:
        studies: how many there were.
        found: in how many the primary test found something.
        wrong: in how many of these the estimate had the wrong sign.
        refused: in how many there was nothing to test; they count as not found.
        by_model: in how many trials were missing, so that the mixed model was primary.
        exaggeration: sum over those found of the estimate, points.
    """

    studies: int = 0
    found: int = 0
    wrong: int = 0
    refused: int = 0
    by_model: int = 0
    exaggeration: float = 0.0


@dataclasses.dataclass(frozen=True, slots=True)
class Piece:
    """Some blocks of one cell: what a worker does at once.

    Attributes:
        cell: number of the cell that they belong to.
        given: the law.
        design: the size.
        seed: of the plan.
        stream: what the studies are for.
        first: the first block.
        blocks: how many.
    """

    cell: int
    given: Assumptions
    design: Design
    seed: int
    stream: str
    first: int
    blocks: int


@dataclasses.dataclass(frozen=True, slots=True)
class Cell:
    """The power of one design.

    Attributes:
        design: the size.
        given: what was assumed.
        counts: what was simulated.
        formula: the closed form; None where there is none.
    """

    design: Design
    given: Assumptions
    counts: Counts
    formula: ClosedForm | None

    @property
    def power(self) -> float:
        """Share of the studies that found something."""
        return self.counts.found / self.counts.studies

    @property
    def interval(self) -> Interval:
        """Wilson's 95 % Monte-Carlo interval of the power."""
        return wilson(self.power, self.counts.studies)

    @property
    def exaggeration(self) -> float | None:
        """Mean estimate of those that found something, as a multiple of the truth; or None."""
        truth = self.given.effects[-1]
        if self.given.conditions > 2 or not self.counts.found or truth == 0:
            return None
        return self.counts.exaggeration / self.counts.found / truth


Runner = Callable[[Sequence[Piece]], Iterable[tuple[int, int, Counts]]]
"""Runs pieces in any order; yields cell, first block and what came of each."""


def run_piece(piece: Piece) -> tuple[int, int, Counts]:
    """Make up studies and test each; return cell, first block and counts."""
    # More threads are slower, as the matrices are small, and may round otherwise.
    with threadpool_limits(limits=1):
        return _run_piece(piece)


def _run_piece(piece: Piece) -> tuple[int, int, Counts]:
    found = wrong = refused = by_model = 0
    exaggeration = 0.0
    truth = piece.given.effects[-1]
    for block in range(piece.first, piece.first + piece.blocks):
        made = make_up(piece.given, piece.design, piece.seed, piece.stream, block)
        tested = analyse_many(made)
        hits = tested.p < piece.given.alpha
        estimates = tested.estimates[hits & np.isfinite(tested.estimates)]
        found += int(hits.sum())
        wrong += int(np.sum(estimates * truth < 0))
        exaggeration += float(estimates.sum())
        refused += int(np.isnan(tested.p).sum())
        by_model += int(tested.by_model.sum())
    counts = Counts(piece.blocks * BLOCK, found, wrong, refused, by_model, exaggeration)
    return piece.cell, piece.first, counts


def run_here(pieces: Sequence[Piece]) -> Iterable[tuple[int, int, Counts]]:
    """Run pieces in this process, one after another."""
    return map(run_piece, pieces)


def simulate(
    wanted: Sequence[tuple[Assumptions, Design]],
    run: Runner,
    *,
    studies: int,
    model_studies: int,
    seed: int,
    stream: str,
) -> list[Cell]:
    """Simulate the power of each design under its assumptions.

    Args:
        wanted: what to simulate.
        run: runs the pieces.
        studies: in each cell, rounded up to whole blocks.
        model_studies: the same where the mixed model may be needed, which is slow.
        seed: of the plan.
        stream: what the studies are for; other names give other studies.

    Returns:
        A cell for each, in that order; the same for any number of workers.
    """
    pieces = []
    for cell, (given, design) in enumerate(wanted):
        count = studies if given.always_means else model_studies
        blocks = math.ceil(count / BLOCK)
        step = QUICK_BLOCKS if given.always_means else 1
        pieces += [
            Piece(cell, given, design, seed, stream, first, min(step, blocks - first))
            for first in range(0, blocks, step)
        ]
    came: list[dict[int, Counts]] = [{} for _ in wanted]
    for cell, first, counts in run(pieces):
        came[cell][first] = counts
    return [
        Cell(design, given, _added([parts[first] for first in sorted(parts)]),
             closed_form(given, design))
        for (given, design), parts in zip(wanted, came, strict=True)
    ]  # fmt: skip


def _added(parts: Sequence[Counts]) -> Counts:
    """Add counts up, in the order of the blocks: a sum of floats depends on it."""
    total = Counts()
    for part in parts:
        total = Counts(
            *(
                getattr(total, field.name) + getattr(part, field.name)
                for field in dataclasses.fields(Counts)
            )
        )
    return total
