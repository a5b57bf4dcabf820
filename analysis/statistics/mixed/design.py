"""From rows to the matrices of a mixed model: treatment coding, as R codes factors."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.statistics.mixed.formula import Formula, RandomTerm, Term

Floats = npt.NDArray[np.float64]
INTERCEPT = "(Intercept)"


class NotEstimableError(ValueError):
    """The rows do not determine the model; the message says why."""


@dataclasses.dataclass(frozen=True, slots=True)
class Column:
    """One column of the fixed design.

    Attributes:
        term: its term; empty for the intercept.
        levels: the level of each factor of the term, as (factor, level).
    """

    term: Term
    levels: tuple[tuple[str, str], ...] = ()

    @property
    def name(self) -> str:
        """R's name of the coefficient: "conditionassisted:trial"."""
        chosen = dict(self.levels)
        return ":".join(name + chosen.get(name, "") for name in self.term) or INTERCEPT


@dataclasses.dataclass(frozen=True, slots=True)
class Block:
    """Random effects of one random term: columns ordered by group, then by effect.

    Attributes:
        group: "participant", "participant:condition".
        effects: names of the effects, length k.
        groups: number of groups, g.
        start: the first column of the block in Z.
    """

    group: str
    effects: tuple[str, ...]
    groups: int
    start: int

    @property
    def size(self) -> int:
        """Number of effects, k."""
        return len(self.effects)

    @property
    def columns(self) -> slice:
        """Its g * k columns of Z."""
        return slice(self.start, self.start + self.groups * self.size)


@dataclasses.dataclass(frozen=True, slots=True)
class Design:
    """Matrices of y = X beta + Z b + e.

    Attributes:
        y: responses, shape (n,).
        x: fixed design, shape (n, p), treatment coding.
        z: random design, shape (n, q).
        columns: what each column of x is.
        blocks: what the columns of z are.
        terms: the fixed terms.
        factors: levels of each factor, the reference first.
    """

    y: Floats
    x: Floats
    z: Floats
    columns: tuple[Column, ...]
    blocks: tuple[Block, ...]
    terms: tuple[Term, ...]
    factors: Mapping[str, tuple[str, ...]]


def build_design(
    frame: pd.DataFrame, formula: Formula, factors: Mapping[str, Sequence[object]]
) -> Design:
    """Build the matrices; rows are sorted first, so that their order changes no bit.

    Args:
        frame: rows without missing values.
        formula: the model.
        factors: levels of each factor among the fixed and random terms, the reference first.

    Raises:
        NotEstimableError: an empty cell, columns that depend on one another, or a grouping
            with a group for each row.
    """
    levels = {name: tuple(str(level) for level in known) for name, known in factors.items()}
    by = [*formula.names, formula.response]
    keyed = frame.assign(**{name: frame[name].astype(str) for name in levels})
    keyed = keyed.sort_values(by, kind="stable").reset_index(drop=True)
    _refuse_missing_cells(keyed, formula, levels)
    columns, values = [Column(())], [np.ones(len(keyed))]
    for term in formula.terms:
        for column, value in _coded(keyed, term, levels):
            columns.append(column)
            values.append(value)
    x = np.column_stack(values)
    _refuse_dependent(x, columns)
    blocks: list[Block] = []
    parts: list[Floats] = []
    for random in formula.random:
        start = blocks[-1].columns.stop if blocks else 0
        block, part = _random_block(keyed, random, levels, start)
        blocks.append(block)
        parts.append(part)
    y = keyed[formula.response].to_numpy(dtype=np.float64)
    z = np.column_stack(parts) if parts else np.empty((len(keyed), 0))
    return Design(y, x, z, tuple(columns), tuple(blocks), formula.terms, levels)


def _coded(
    frame: pd.DataFrame, term: Term, levels: Mapping[str, tuple[str, ...]], *, every: bool = False
) -> list[tuple[Column, Floats]]:
    """Code a term; every level of its factors, or all but the reference."""
    chosen = [name for name in term if name in levels]
    base = np.ones(len(frame))
    for name in term:
        if name not in levels:
            base = base * frame[name].to_numpy(dtype=np.float64)
    coded = []
    # As in R, levels of the first factor vary fastest.
    kept = [levels[name] if every else levels[name][1:] for name in reversed(chosen)]
    for combination in itertools.product(*kept):
        pairs = tuple(zip(chosen, reversed(combination), strict=True))
        value = base.copy()
        for name, level in pairs:
            value *= (frame[name] == level).to_numpy(dtype=np.float64)
        coded.append((Column(term, pairs), value))
    return coded


def sum_to_zero(design: Design) -> Floats:
    """Return the fixed design in sum-to-zero coding, columns in the same order, shape (n, p).

    A level's column is 1 for it and -1 for the reference, as those of R's contr.sum up to the order
    of levels, so that dropping the columns of a term tests it at the mean of the other factors.
    """
    plain = {
        (name, level): column
        for column, place in zip(design.x.T, design.columns, strict=True)
        if len(place.term) == 1
        for name, level in (place.levels or ((place.term[0], ""),))
    }
    coded = [np.ones(len(design.y))]
    for place in design.columns[1:]:
        chosen, value = dict(place.levels), np.ones(len(design.y))
        for name in place.term:
            if name in chosen:
                rest = np.sum([plain[name, lv] for lv in design.factors[name][1:]], axis=0)
                value = value * (plain[name, chosen[name]] - (1 - rest))
            else:
                value = value * plain[name, ""]
        coded.append(value)
    return np.column_stack(coded)


def _random_block(
    frame: pd.DataFrame, random: RandomTerm, levels: Mapping[str, tuple[str, ...]], start: int
) -> tuple[Block, Floats]:
    keys = list(zip(*(frame[name].astype(str) for name in random.group), strict=True))
    groups = {key: place for place, key in enumerate(sorted(set(keys)))}
    label = ":".join(random.group)
    effects = [(Column(()), np.ones(len(frame)))] if random.intercept else []
    for place, term in enumerate(random.terms):
        every = not random.intercept and place == 0
        effects += _coded(frame, term, levels, every=every)
    if len(groups) * len(effects) >= len(frame):
        raise NotEstimableError(
            f"There are {len(frame)} rows for {len(groups)} groups of {label} with "
            f"{len(effects)} random effect(s) each, so that these cannot be told from the "
            "residual scatter."
        )
    part = np.zeros((len(frame), len(groups) * len(effects)))
    rows, codes = np.arange(len(frame)), np.array([groups[key] for key in keys])
    for place, (_, value) in enumerate(effects):
        part[rows, codes * len(effects) + place] = value
    names = tuple(column.name for column, _ in effects)
    return Block(label, names, len(groups), start), part


def _refuse_missing_cells(
    frame: pd.DataFrame, formula: Formula, levels: Mapping[str, tuple[str, ...]]
) -> None:
    for term in formula.terms:
        chosen = [name for name in term if name in levels]
        present = set(zip(*(frame[name] for name in chosen), strict=True)) if chosen else set()
        for cell in itertools.product(*(levels[name] for name in chosen)):
            if chosen and cell not in present:
                where = " and ".join(f"{n} {v}" for n, v in zip(chosen, cell, strict=True))
                raise NotEstimableError(f"There are no rows with {where}.")
    for term in formula.terms:
        for name in term:
            if term != (name,) and (name,) not in formula.terms:
                raise NotEstimableError(
                    f"The interaction {':'.join(term)} needs {name} as a term of its own."
                )


def _refuse_dependent(x: Floats, columns: Sequence[Column]) -> None:
    scaled = x / np.maximum(np.linalg.norm(x, axis=0), 1e-300)
    for width in range(1, x.shape[1] + 1):
        if np.linalg.matrix_rank(scaled[:, :width], tol=1e-7) < width:
            raise NotEstimableError(
                f"The rows do not determine the coefficient {columns[width - 1].name}: it "
                "depends on those before it."
            )
    if x.shape[0] <= x.shape[1]:
        raise NotEstimableError(
            f"There are {x.shape[0]} rows for {x.shape[1]} coefficients; more rows are needed."
        )


def type_three(design: Design, term: Term) -> Floats:
    """Return the contrasts of a type III test, shape (df, p).

    A row compares a level with the reference, averaged over the levels of all other factors
    with equal weight, at zero of covariates that are not part of the term: what lmerTest's
    `anova` tests in the parametrisation of treatment coding.
    """
    rows = [column for column in design.columns if column.term == term]
    if len(design.terms) == 1:
        return _first_term(design, term)
    covariates = {name for name in term if name not in design.factors}
    contrasts = np.zeros((len(rows), len(design.columns)))
    for place, row in enumerate(rows):
        for other, column in enumerate(design.columns):
            numeric = {name for name in column.term if name not in design.factors}
            chosen = dict(column.levels)
            same = all(chosen.get(name) == level for name, level in row.levels)
            if numeric == covariates and same and set(term) <= set(column.term):
                rest = [n for n in chosen if n not in term]
                contrasts[place, other] = 1 / math.prod(len(design.factors[n]) for n in rest)
    return contrasts


def _first_term(design: Design, term: Term) -> Floats:
    """Return a single term's contrasts as lmerTest does: rows of Doolittle's factor of X'X."""
    factor = np.linalg.cholesky(design.x.T @ design.x).T
    unit = factor / np.diag(factor)[:, None]
    return unit[[place for place, c in enumerate(design.columns) if c.term == term]]
