"""Ratings and instruments' scores by the factors that conditions cross."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Generic, TypeVar

import numpy as np
import pandas as pd

from analysis.factorial import effects_of_means
from analysis.factors import Crossing, Factor
from analysis.statistics.cells import Cells
from analysis.statistics.cumulative_link import CumulativeLink, cumulative_link_model
from analysis.statistics.holm import holm_of
from analysis.statistics.likert import LikertRow, rank_test
from analysis.statistics.result import EffectResult, Outcome, Refusal
from analysis.statistics.scale_scores import ScaleRow

Row = TypeVar("Row", LikertRow, ScaleRow)


@dataclasses.dataclass(frozen=True, slots=True)
class FactorEffect:
    """One main effect or interaction on one item or scale, on one occasion.

    Attributes:
        name: the effect: "Allocation", "Allocation × Fleet size".
        f_test: of participants' cell means, Greenhouse and Geisser's where it has several degrees
            of freedom; its p_adjusted is Holm's over all effects on all items or scales.
        rank_test: of a factor's levels, averaged over the others: signed ranks of two, Friedman's
            of more; Holm-adjusted likewise. None for an interaction, which ranks do not test.
        ordinal: of a rating, the likelihood ratio in a cumulative-link mixed model; Holm-adjusted
            likewise. None for scores.
    """

    name: str
    f_test: Outcome
    rank_test: Outcome | None
    ordinal: Outcome | None


@dataclasses.dataclass(frozen=True, slots=True)
class ByFactor(Generic[Row]):
    """Every effect on one item or scale.

    Attributes:
        row: the item or scale, with its cells.
        effects: main effects first.
    """

    row: Row
    effects: tuple[FactorEffect, ...]


def ratings_by_factor(
    crossing: Crossing | None, ratings: Sequence[LikertRow], responses: pd.DataFrame
) -> tuple[ByFactor[LikertRow], ...]:
    """Test each effect on each item and occasion; nothing where no factors are crossed.

    Args:
        crossing: the factors that the conditions cross.
        ratings: the items on their occasions.
        responses: columns "participant", "condition", "item", "occasion", "answer".
    """
    if crossing is None:
        return ()
    found = []
    for row in ratings:
        asked = responses[(responses["item"] == row.item) & (responses["occasion"] == row.occasion)]
        found.append(ByFactor(row, _effects(crossing, row.cells, _ordinal(crossing, asked))))
    return tuple(_adjusted(found))


def scales_by_factor(
    crossing: Crossing | None, scales: Sequence[ScaleRow]
) -> tuple[ByFactor[ScaleRow], ...]:
    """Test each effect on each scale and occasion; nothing where no factors are crossed."""
    if crossing is None:
        return ()
    compared = [row for row in scales if row.compared]
    return tuple(_adjusted([ByFactor(row, _effects(crossing, row.cells)) for row in compared]))


def level_cells(crossing: Crossing, factor: Factor, cells: Cells) -> Cells:
    """Average each participant's cells over the other factors: one mean for each level."""
    place = crossing.factors.index(factor)
    of_level = {
        level: [name for name in cells.levels if crossing.cells[name][place] == level]
        for level in factor.levels
    }
    means = [np.mean([cells.column(c) for c in own], axis=0) for own in of_level.values()]
    counts = [
        np.sum([cells.counts[:, cells.levels.index(c)] for c in own], axis=0)
        for own in of_level.values()
    ]
    return dataclasses.replace(
        cells, levels=factor.levels, means=np.column_stack(means), counts=np.column_stack(counts)
    )


def _effects(
    crossing: Crossing, cells: Cells, ordinal: dict[str, Outcome] | None = None
) -> tuple[FactorEffect, ...]:
    tests = effects_of_means(crossing, cells)
    names = [
        ":".join(chosen)
        for size in range(1, len(crossing.factors) + 1)
        for chosen in itertools.combinations(crossing.levels, size)
    ]
    single = {factor.name: factor for factor in crossing.factors}
    if len(tests) != len(names):  # refused as a whole
        tests = [tests[0]] * len(names)
    return tuple(
        FactorEffect(
            name=crossing.label(name),
            f_test=test,
            rank_test=rank_test(level_cells(crossing, single[name], cells), crossing.label(name))
            if name in single
            else None,
            ordinal=ordinal.get(name) if ordinal is not None else None,
        )
        for name, test in zip(names, tests, strict=True)
    )


def _ordinal(crossing: Crossing, asked: pd.DataFrame) -> dict[str, Outcome]:
    conditions = asked["condition"].astype("str")
    rows = asked[conditions.isin(list(crossing.cells))]
    placed = {
        factor: conditions[rows.index].map({c: cell[place] for c, cell in crossing.cells.items()})
        for place, factor in enumerate(crossing.levels)
    }
    formula = f"answer ~ {' * '.join(crossing.levels)} + (1 | participant)"
    model = cumulative_link_model(rows.assign(**placed), formula, crossing.levels)
    if isinstance(model, CumulativeLink):
        return {test.name.split(": ", 1)[1]: test for test in model.tests}
    sizes = range(1, len(crossing.factors) + 1)
    every = itertools.chain(*(itertools.combinations(crossing.levels, size) for size in sizes))
    return {":".join(chosen): model for chosen in every}


def _adjusted(found: list[ByFactor[Row]]) -> list[ByFactor[Row]]:
    """Adjust each kind of test over every effect in which it was computed."""
    effects = [effect for one in found for effect in one.effects]
    nothing = Refusal("", "")
    columns = []
    for kind in ("f_test", "rank_test", "ordinal"):
        tests = [getattr(effect, kind) for effect in effects]
        adjusted = holm_of([nothing if test is None else test for test in tests])
        columns.append(
            [
                dataclasses.replace(test, p_adjusted=p) if isinstance(test, EffectResult) else test
                for test, p in zip(tests, adjusted, strict=True)
            ]
        )
    made = iter(
        FactorEffect(effect.name, *tests) for effect, *tests in zip(effects, *columns, strict=True)
    )
    return [
        dataclasses.replace(one, effects=tuple(next(made) for _ in one.effects)) for one in found
    ]
