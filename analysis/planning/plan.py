"""A plan: power over a grid, the smallest design that reaches it, and what else might be true."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.closed_form import smallest_participants
from analysis.planning.pilot import Pilot
from analysis.planning.power import Cell, Runner, simulate

CHECK = 4
"""So many times as many studies check the design chosen as estimated it."""
MOST = 400
"""Participants up to which a size is looked for by the closed form."""
STEPS = 8
"""Numbers of participants in a grid that nobody gave."""


@dataclasses.dataclass(frozen=True, slots=True)
class Wanted:
    """What a plan is asked for.

    Attributes:
        designs: the grid, sorted.
        power: wanted.
        studies: simulated in each cell.
        model_studies: the same where the mixed model may be needed.
        seed: of everything drawn.
        step: the interval of the grid below the size named is halved until it is no wider than
            this; 0 for the grid alone.
    """

    designs: tuple[Design, ...]
    power: float
    studies: int
    model_studies: int
    seed: int
    step: int = 0


@dataclasses.dataclass(frozen=True, slots=True)
class Variation:
    """The chosen design, were something else true.

    Attributes:
        text: what else.
        cell: its power then.
    """

    text: str
    cell: Cell


@dataclasses.dataclass(frozen=True, slots=True)
class Plan:
    """What came out.

    Attributes:
        given: what was assumed.
        wanted: what was asked for.
        pilot: whence assumptions come; None if all were given.
        cells: the grid's, in its order.
        chosen: the smallest design that reaches the power; None if none does.
        check: its fresh simulation.
        failed: fresh simulations of smaller designs that fell short.
        variations: of the chosen design, or of the best if none is.
        by_formula: where no design reaches the power, participants that would by the closed form,
            for each number of trials of the grid; None where more than are looked for.
    """

    given: Assumptions
    wanted: Wanted
    pilot: Pilot | None
    cells: tuple[Cell, ...]
    chosen: Cell | None
    check: Cell | None
    failed: tuple[Cell, ...]
    variations: tuple[Variation, ...]
    by_formula: tuple[tuple[int, int | None], ...]

    @property
    def best(self) -> Cell:
        """The chosen design, or else the one with the most power; the smallest of equals."""
        return self.chosen or max(self.cells, key=lambda cell: cell.power)


def grid(participants: tuple[int, ...], trials: tuple[int, ...]) -> tuple[Design, ...]:
    """Return every size of a grid, the smallest first."""
    return tuple(Design(n, k) for n in sorted(set(participants)) for k in sorted(set(trials)))


def default_participants(
    given: Assumptions, trials: tuple[int, ...], power: float
) -> tuple[int, ...]:
    """Return numbers of participants about those that the closed form names.

    They are multiples of the number of orders, so that these balance; from three quarters of
    what most trials need to five quarters of what fewest need.
    """
    step = len(given.orders)
    need = [smallest_participants(given, k, power, step, MOST) or MOST for k in trials]
    low = max(step * -(-3 // step), int(0.75 * min(need)) // step * step)
    high = min(MOST, -(-int(1.25 * max(need)) // step) * step)
    stride = step * max(1, -(-(high - low) // (step * (STEPS - 1))))
    return (*range(low, high, stride), high)


def make_plan(given: Assumptions, wanted: Wanted, pilot: Pilot | None, run: Runner) -> Plan:
    """Simulate the grid, choose, check afresh, and vary what was assumed.

    Chosen is the smallest design (fewest participants, then fewest trials) of which the whole
    Monte-Carlo interval reaches the wanted power. It is simulated afresh: the smallest of many is
    also the luckiest. If the fresh power falls short, the next takes its place.
    """
    sizes = {"studies": wanted.studies, "model_studies": wanted.model_studies}

    def simulated(designs: Sequence[Design]) -> list[Cell]:
        pairs = [(given, design) for design in designs]
        return simulate(pairs, run, **sizes, seed=wanted.seed, stream="grid")

    cells = simulated(wanted.designs)
    while between := _between(cells, wanted):
        cells = sorted(cells + simulated(between), key=lambda cell: cell.design)
    more = {name: CHECK * count for name, count in sizes.items()}
    chosen, check = None, None
    failed: list[Cell] = []
    for cell in _reaching(cells, wanted.power):
        fresh = simulate([(given, cell.design)], run, **more, seed=wanted.seed, stream="check")[0]
        if fresh.power >= wanted.power:
            chosen, check = cell, fresh
            break
        failed.append(fresh)
    best = chosen or max(cells, key=lambda cell: cell.power)
    others = variations(given, pilot)
    varied = simulate(
        [(changed, best.design) for _, changed in others],
        run,
        **sizes,
        seed=wanted.seed,
        stream="variation",
    )
    named = [Variation(text, cell) for (text, _), cell in zip(others, varied, strict=True)]
    step = len(given.orders)
    by_formula = () if chosen else tuple(
        (k, smallest_participants(given, k, wanted.power, step, MOST))
        for k in sorted({design.trials for design in wanted.designs})
    )  # fmt: skip
    return Plan(
        given, wanted, pilot, tuple(cells), chosen, check, tuple(failed), tuple(named), by_formula
    )


def _reaching(cells: Sequence[Cell], power: float) -> list[Cell]:
    """Return those whose whole interval reaches a power, in the order given."""
    return [cell for cell in cells if cell.interval.low >= power]


def _between(cells: Sequence[Cell], wanted: Wanted) -> tuple[Design, ...]:
    """Return sizes midway between the first participants that reach it and those just below.

    None where these are neighbours, or where the grid alone is asked for.
    """
    reaching = _reaching(cells, wanted.power)
    if not reaching or not wanted.step:
        return ()
    first = min(cell.design.participants for cell in reaching)
    below = [n for cell in cells if (n := cell.design.participants) < first]
    steps = (first - max(below, default=first)) // wanted.step
    if steps < 2:
        return ()
    middle = first - steps // 2 * wanted.step
    return grid((middle,), tuple({design.trials for design in wanted.designs}))


def variations(given: Assumptions, pilot: Pilot | None) -> list[tuple[str, Assumptions]]:
    """Return what else might be true, in words and as assumptions; as assumed is the first."""
    changed = dataclasses.replace

    def scaled(factor: float) -> tuple[float, ...]:
        return tuple(factor * effect for effect in given.effects)

    found = [
        ("As assumed", given),
        ("Three quarters of the effect", changed(given, effects=scaled(0.75))),
        ("Half the effect", changed(given, effects=scaled(0.5))),
        ("No effect: false alarms", changed(given, effects=scaled(0.0))),
    ]
    if given.effect_sd:
        wider = changed(given, effect_sd=1.25 * given.effect_sd)
        found.append(("Participants differ a quarter more in the effect", wider))
    noisier = changed(given, trial_sd=1.25 * given.trial_sd)
    found.append(("Trials scatter a quarter more", noisier))
    if given.drop_out:
        leaving = changed(given, drop_out=min(0.9, 2 * given.drop_out))
        found.append(("Twice as many leave", leaving))
    if pilot is not None:
        found += pilot.bounds(given)
    return found
