"""Sentences in the style of the American Psychological Association, to copy."""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.formatting import (
    counted,
    fraction,
    interval,
    listed,
    number,
    p_text,
    plain_statistic,
)
from analysis.results import StudyResults
from analysis.sections import by_factor, effects, scored
from analysis.sections.ratings import label
from analysis.statistics.reliability import Reliability
from analysis.statistics.result import EffectResult, EffectSize
from analysis.statistics.scale_scores import ScaleRow

_NAMES = {"d_z": "dz", "g_z": "gz", "r_rb": "rank-biserial r", "partial eta squared": "partial η²"}
_BOUNDED = {"r_rb", "Kendall's W", "partial eta squared", "generalised eta squared"}


@dataclasses.dataclass(frozen=True, slots=True)
class Sentence:
    """One result in words: a heading, and plain text to copy."""

    key: str
    heading: str
    text: str


def sentences(results: StudyResults) -> list[Sentence]:
    """Write a sentence for every test that was computed."""
    found: list[tuple[str, str]] = []
    test = results.primary
    if isinstance(test, EffectResult):
        found.append(("Team reward, primary test", _reward(results, test)))
    found += [
        (outcome.name, f"{outcome.name}: {numbers(outcome)}.")
        for outcome in results.sensitivity
        if isinstance(outcome, EffectResult)
    ]
    found += [
        (f"Effect: {effect.name}", f"{effect.name}: {numbers(effect)}{_holm(effect)}.")
        for effect in effects.effects(results)
    ]
    found += [
        (f"Pair: {test.name}", f"{test.name}: {numbers(test)}{_holm(test)}.")
        for test in effects.pairs(results)
    ]
    for row in results.ratings:
        if isinstance(row.rank_test, EffectResult) and row.means:
            means = ", ".join(
                f"{results.facts.label(level)} M = {number(mean)}"
                for level, mean in row.means.items()
            )
            adjusted = f", Holm-adjusted {p_text(row.holm_p)}" if row.holm_p is not None else ""
            how = "exact Wilcoxon" if len(row.cells.levels) == 2 else "Friedman"
            text = f"{label(row)} ({means}), {how}: {numbers(row.rank_test)}{adjusted}."
            found.append((f"Rating {label(row)}", text))
    found += [
        (f"{name}: {effect.name}", f"{name}, {effect.name}: {numbers(test)}{_holm(test)}.")
        for name, effect, test in by_factor.tested(results)
    ]
    found += [
        (f"Score {scored.full_name(row)}", _score(results, row))
        for row in results.scales
        if isinstance(row.f_test, EffectResult)
    ]
    if isinstance(results.phase_four.test, EffectResult):
        text = f"Policies on their own: {numbers(results.phase_four.test)}."
        found.append(("Phase four", text))
    return [
        Sentence(f"sentence-{place}", heading, text.replace("\u00a0", " "))
        for place, (heading, text) in enumerate(found, start=1)
    ]


def numbers(result: EffectResult) -> str:
    """Write statistic, p, estimate and effect size in a row."""
    parts = [plain_statistic(result), p_text(result.p)]
    if result.estimate is not None:
        text = f"difference {number(result.estimate)}"
        if result.interval is not None:
            text += f", {result.interval.level:.0%} CI {interval(result.interval)}"
        parts.append(text)
    if result.effects:
        parts.append(_size(result.effects[0]))
    return ", ".join(parts)


def _holm(result: EffectResult) -> str:
    return f", Holm-adjusted {p_text(result.p_adjusted)}" if result.p_adjusted is not None else ""


def _reward(results: StudyResults, test: EffectResult) -> str:
    cells = results.cells
    means = [
        f"{name} (M = {number(float(np.mean(np.sort(column))))}, "
        f"SD = {number(float(np.std(np.sort(column), ddof=1)))})"
        for name, column in zip(results.labels, cells.means.T, strict=True)
    ]
    people = counted(len(test.participants), "participant")
    how = (
        "linear mixed model of the trials with Kenward and Roger’s degrees of freedom"
        if results.by_trial
        else "repeated-measures ANOVA on participant means"
    )
    return (
        f"Mean team reward of {people} was compared between {listed(means)} by a {how}, "
        f"{numbers(test)}."
    )


def _score(results: StudyResults, row: ScaleRow) -> str:
    """Write means, test and reliability of a scale."""
    means = ", ".join(
        f"{label} M = {number(float(np.mean(np.sort(column))))}"
        for label, column in zip(results.labels, row.cells.means.T, strict=True)
    )
    assert isinstance(row.f_test, EffectResult)  # noqa: S101 - the caller has seen it
    adjusted = f", Holm-adjusted {p_text(row.holm_f_p)}" if row.holm_f_p is not None else ""
    alphas = [
        fraction(found.alpha) for _, found in row.reliability if isinstance(found, Reliability)
    ]
    reliability = f" Cronbach’s α = {listed(alphas)} under the conditions." if alphas else ""
    return f"{scored.full_name(row)} ({means}): {numbers(row.f_test)}{adjusted}.{reliability}"


def _size(size: EffectSize) -> str:
    bounded = size.name in _BOUNDED
    value = fraction(size.value) if bounded else number(size.value)
    text = f"{_NAMES.get(size.name, size.name)} = {value}"
    if size.interval is not None:
        text += f", {size.interval.level:.0%} CI {interval(size.interval, bounded=bounded)}"
    return text
