"""Which size a plan names, and that it stands."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterable, Sequence

import pytest

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.plan import Plan, Wanted, default_participants, grid, make_plan
from analysis.planning.power import Counts, Piece, run_here, run_piece, simulate
from analysis.planning.words import details, headline
from assumed_law import law, planned
from study.workers import run_pieces

WANTED = Wanted(grid((8, 12, 16, 20), (4, 8)), 0.8, 2000, 50, 11)


def plan(assumed: Assumptions, **changes: object) -> Plan:
    return make_plan(assumed, dataclasses.replace(WANTED, **changes), None, run_here)  # type: ignore[arg-type]


def shuffled(pieces: Sequence[Piece]) -> Iterable[tuple[int, int, Counts]]:
    """Run pieces as many workers would: in an order that nobody knows."""
    mixed = list(pieces)
    random.Random(4).shuffle(mixed)
    return map(run_piece, mixed)


def test_the_size_named_reaches_the_power_in_studies_of_its_own() -> None:
    """The smallest whose whole interval reaches it; fresh seeds, here too, agree."""
    found = plan(law(period=2.0))
    assert found.chosen is not None
    assert found.check is not None
    for cell in found.cells:
        if cell.design < found.chosen.design:
            assert cell.interval.low < 0.8
    assert found.chosen.interval.low >= 0.8
    assert found.check.power >= 0.8
    assert found.check.counts.studies == 8000
    assert found.check.counts.found != 4 * found.chosen.counts.found
    fresh = simulate(
        [(found.given, found.chosen.design)],
        run_here,
        studies=20_000,
        model_studies=1,
        seed=999,
        stream="another",
    )[0]
    assert fresh.power >= 0.8
    assert "the smallest size in the grid that finds an effect of 6 points" in headline(found)


def test_fewest_participants_come_before_fewest_trials() -> None:
    """Trials are cheaper than people."""
    found = plan(law(effects=(0.0, 9.0)))
    assert found.chosen is not None
    assert found.chosen.design == Design(8, 8)
    larger = [cell for cell in found.cells if cell.design == Design(12, 4)]
    assert larger[0].interval.low >= 0.8
    assert "It is the smallest size" not in " ".join(details(found, planned()))


def test_a_lucky_size_gives_way_to_the_next() -> None:
    """What reached the power in the grid only is told of, and not named."""

    def unlucky(pieces: Sequence[Piece]) -> Iterable[tuple[int, int, Counts]]:
        for piece in pieces:
            cell, first, counts = run_piece(piece)
            if piece.stream == "check" and piece.design == Design(8, 8):
                counts = dataclasses.replace(counts, found=0)
            yield cell, first, counts

    found = make_plan(law(effects=(0.0, 9.0)), WANTED, None, unlucky)
    assert [cell.design for cell in found.failed] == [Design(8, 8)]
    assert found.chosen is not None
    assert found.chosen.design == Design(12, 4)
    said = " ".join(details(found, planned()))
    assert "reached the power in the grid, but not afresh" in said


def test_no_size_that_reaches_it_is_said_with_what_would() -> None:
    """None is named; the closed form tells how many it takes."""
    found = plan(law(effects=(0.0, 3.0)), designs=grid((8, 12), (8,)))
    assert found.chosen is None
    assert found.check is None
    assert "No size in the grid" in headline(found)
    assert found.best.design == Design(12, 8)
    ((trials, count),) = found.by_formula
    assert trials == 8
    assert count is not None
    assert f"{count}\u00a0participants with 8\u00a0trials" in " ".join(details(found, planned()))
    again = plan(law(effects=(0.0, 3.0)), designs=grid((count, count + 6), (8,)))
    assert again.chosen is not None


def test_between_the_sizes_of_its_own_grid_it_looks_closer() -> None:
    """The size named is the smallest multiple of the orders, not of the grid's stride."""
    coarse = plan(law(), designs=grid((6, 26), (8,)))
    fine = plan(law(), designs=grid((6, 26), (8,)), step=2)
    assert coarse.chosen is not None
    assert fine.chosen is not None
    assert coarse.chosen.design == Design(26, 8)
    assert fine.chosen.design == Design(14, 8)  # by the closed form too
    assert [cell.design.participants for cell in fine.cells] == [6, 12, 14, 16, 26]
    assert coarse.cells[0] == fine.cells[0]


def test_a_grid_of_its_own_holds_what_the_closed_form_names() -> None:
    """Below and above the sizes that reach the power, in multiples of the orders."""
    sizes = default_participants(law(), (4, 8, 16), 0.8)
    assert all(size % 2 == 0 for size in sizes)
    assert sizes[0] < 14 < sizes[-1]
    assert len(sizes) <= 9
    hopeless = default_participants(law(effects=(0.0, 0.0)), (8,), 0.8)
    assert max(hopeless) == 400


def two(pieces: Sequence[Piece]) -> Iterable[tuple[int, int, Counts]]:
    """Run pieces in two processes."""
    return run_pieces(run_piece, [(piece,) for piece in pieces], jobs=2)


def test_results_hang_on_no_order_and_no_number_of_workers() -> None:
    """One process, another order, two processes: the very same plan."""
    wanted = dataclasses.replace(WANTED, designs=grid((6, 8), (2, 4)), power=0.2)
    here = make_plan(law(period=3.0), wanted, None, run_here)
    assert here.chosen is not None
    assert make_plan(law(period=3.0), wanted, None, shuffled) == here
    assert make_plan(law(period=3.0), wanted, None, two) == here


@pytest.mark.acceptance
def test_nor_do_those_of_the_mixed_model() -> None:
    """The slow studies go to workers a block at a time."""
    pairs = [(law(drop_out=0.2), Design(5, 2)), (law(missing=0.1), Design(4, 2))]
    sizes = {"studies": 1, "model_studies": 60, "seed": 4}
    here = simulate(pairs, run_here, **sizes, stream="x")
    assert all(cell.counts.by_model for cell in here)
    assert simulate(pairs, shuffled, **sizes, stream="x") == here
    assert simulate(pairs, two, **sizes, stream="x") == here


def test_other_assumptions_are_simulated_as_named() -> None:
    """Less effect, more scatter and more losses cost power; without an effect the level is left."""
    found = plan(law(drop_out=0.1, needed=1.0), designs=grid((14,), (8,)))
    powers = {row.text: row.cell.power for row in found.variations}
    assumed = powers.pop("As assumed")
    assert all(power < assumed for power in powers.values())
    assert powers["No effect: false alarms"] == pytest.approx(0.05, abs=0.02)
    assert powers["Half the effect"] < powers["Three quarters of the effect"]
    assert "Twice as many leave" in powers
