"""Ratings and scores by the factors that conditions cross: words, figures and tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from analysis.factor_answers import ByFactor, FactorEffect, Row, level_cells
from analysis.factors import Crossing
from analysis.figures.factor_panels import Panel, factor_panels, spread_panels
from analysis.figures.svg import Drawing
from analysis.formatting import listed, number
from analysis.results import StudyResults
from analysis.sections import ratings, scored
from analysis.statistics.likert import LikertRow
from analysis.statistics.result import ALPHA, EffectResult, Refusal
from analysis.statistics.scale_scores import ScaleRow


@dataclasses.dataclass(frozen=True, slots=True)
class EffectRow:
    """One effect in a table: the means that it compares, and its tests."""

    name: str
    means: str
    effect: FactorEffect


@dataclasses.dataclass(frozen=True, slots=True)
class EffectGroup:
    """The effects on one item or scale."""

    heading: str
    people: int
    rows: tuple[EffectRow, ...]


def rating_finding(results: StudyResults) -> str:
    """Say which effects were detected on which items."""
    return _finding(results, results.rating_effects, lambda one: ratings.label(one.row))


def scale_finding(results: StudyResults) -> str:
    """Say which effects were detected on which scales."""
    return _finding(results, results.scale_effects, lambda one: scored.full_name(one.row))


def rating_groups(results: StudyResults) -> list[EffectGroup]:
    """Lay out the effects on each item."""
    return _groups(results, results.rating_effects, lambda one: _rating_heading(one.row))


def scale_groups(results: StudyResults) -> list[EffectGroup]:
    """Lay out the effects on each scale."""
    return _groups(results, results.scale_effects, lambda one: scored.full_name(one.row))


def rating_figure(results: StudyResults) -> Drawing | None:
    """Draw mean answers by factor; None where nothing is crossed or nobody answered everything."""
    items = results.facts.items
    panels = []
    for one in results.rating_effects:
        item = items.get(one.row.item)
        high = item.high if item else max(7.0, float(one.row.cells.means.max(initial=0.0)))
        when = one.row.occasion.replace("_", " ")
        low = float(item.low) if item else 1.0
        panels.append(Panel(ratings.label(one.row), when, one.row.cells, low, float(high)))
    return _figure(results.facts.crossing, "rating-factors", "Mean answers", panels)


def scale_figure(results: StudyResults) -> Drawing | None:
    """Draw mean scores by factor; None where nothing is crossed or nobody has every score."""
    panels = []
    for one in results.scale_effects:
        asked, cells = one.row.asked, one.row.cells
        low, high = asked.lowest, asked.highest
        if not (np.isfinite(low) and np.isfinite(high) and high > low):
            low, high = float(cells.means.min(initial=0.0)), float(cells.means.max(initial=1.0))
            high = max(high, low + 1)
        when = asked.occasion.replace("_", " ")
        panels.append(Panel(scored.name(one.row), when, cells, low, high))
    return _figure(results.facts.crossing, "score-factors", "Mean scores", panels)


def refusals(
    found: Sequence[ByFactor[Row]], heading: Callable[[ByFactor[Row]], str]
) -> list[Refusal]:
    """Return what was refused, each reason once for an item or scale."""
    unique: dict[tuple[str, str], Refusal] = {}
    for one in found:
        for effect in one.effects:
            for test in (effect.f_test, effect.ordinal):
                if isinstance(test, Refusal):
                    kind = " (ordinal model)" if test is effect.ordinal else ""
                    whole = f"{heading(one)}, {effect.name}{kind}"
                    unique.setdefault((heading(one), test.reason), Refusal(whole, test.reason))
    return list(unique.values())


def tested(results: StudyResults) -> list[tuple[str, FactorEffect, EffectResult]]:
    """Return every effect on an item or scale whose F was computed, with the item's name."""
    named = [(f"Rating {ratings.label(one.row)}", one.effects) for one in results.rating_effects]
    named += [(f"Score {scored.full_name(one.row)}", one.effects) for one in results.scale_effects]
    return [
        (name, effect, effect.f_test)
        for name, own in named
        for effect in own
        if isinstance(effect.f_test, EffectResult)
    ]


def rating_refusals(results: StudyResults) -> list[Refusal]:
    """Return the refused effects on items."""
    return refusals(results.rating_effects, lambda one: ratings.label(one.row))


def scale_refusals(results: StudyResults) -> list[Refusal]:
    """Return the refused effects on scales."""
    return refusals(results.scale_effects, lambda one: scored.full_name(one.row))


def _rating_heading(row: LikertRow) -> str:
    return f"{ratings.label(row)}, {row.occasion.replace('_', ' ')}"


def _figure(
    crossing: Crossing | None, name: str, what: str, panels: Sequence[Panel]
) -> Drawing | None:
    shown = [panel for panel in panels if panel.cells.n]
    if crossing is None or not shown:
        return None
    spread = [part for panel in shown for part in spread_panels(crossing, panel)]
    by = listed([factor.label.lower() for factor in crossing.factors])
    return factor_panels(name, f"{what} by {by}, {len(spread)} panels", crossing, spread)


def _finding(
    results: StudyResults,
    found: Sequence[ByFactor[Row]],
    heading: Callable[[ByFactor[Row]], str],
) -> str:
    """Say by the corrected F, Holm-adjusted over all effects, where each effect was detected."""
    if not found:
        return ""
    places: dict[str, list[str]] = {}
    tested = 0
    for one in found:
        for effect in one.effects:
            names = places.setdefault(effect.name, [])
            if isinstance(effect.f_test, EffectResult):
                tested += 1
                if (effect.f_test.p_adjusted or 0.0) < ALPHA:
                    names.append(heading(one))
    if not tested:
        return "Effects of factors were not tested."
    sentences = [
        f"{_first_upper(name.lower())} {'interacted' if '×' in name else 'made a difference'} on "
        f"{listed(where)}."
        for name, where in places.items()
        if where
    ]
    nowhere = [_spoken(results, name) for name, where in places.items() if not where]
    if nowhere:
        either = f"{', '.join(nowhere[:-1])} or {nowhere[-1]}" if nowhere[1:] else nowhere[0]
        sentences.append(f"No effect was detected of {either}.")
    sentences.append(
        f"This goes by the corrected F test with Holm’s adjustment over {tested} effects."
    )
    return " ".join(sentences)


def _groups(
    results: StudyResults,
    found: Sequence[ByFactor[Row]],
    heading: Callable[[ByFactor[Row]], str],
) -> list[EffectGroup]:
    crossing = results.facts.crossing
    if crossing is None:
        return []
    return [
        EffectGroup(
            heading(one),
            one.row.cells.n,
            tuple(
                EffectRow(effect.name, _means(crossing, one.row, effect.name), effect)
                for effect in one.effects
            ),
        )
        for one in found
    ]


def _means(crossing: Crossing, row: LikertRow | ScaleRow, effect: str) -> str:
    """Write the mean at each level of a factor; nothing for an interaction."""
    factor = next((factor for factor in crossing.factors if factor.label == effect), None)
    if factor is None or row.cells.n == 0:
        return ""
    columns = level_cells(crossing, factor, row.cells).means.T
    decimals = 1 if isinstance(row, ScaleRow) and row.asked.highest - row.asked.lowest > 20 else 2
    return ", ".join(
        f"{label} {number(float(np.mean(np.sort(column))), decimals)}"
        for label, column in zip(factor.level_labels, columns, strict=True)
    )


def _spoken(results: StudyResults, name: str) -> str:
    crossing = results.facts.crossing
    two = crossing is not None and len(crossing.factors) == 2
    return "the interaction" if "×" in name and two else name.lower()


def _first_upper(text: str) -> str:
    return text[:1].upper() + text[1:]
