"""Scored instruments: scores under each condition, their tests, and how reliable scales are."""

from __future__ import annotations

import dataclasses

from analysis.figures.scale_scores import score_dots
from analysis.figures.svg import Drawing
from analysis.formatting import counted, fraction, listed, number
from analysis.results import StudyResults
from analysis.statistics.reliability import Reliability
from analysis.statistics.result import ALPHA, EffectResult, Interval, Refusal
from analysis.statistics.scale_scores import ScaleRow


@dataclasses.dataclass(frozen=True, slots=True)
class AlphaRow:
    """Reliability of a scale on one occasion under one condition; numbers as written.

    Attributes:
        name: the scale and when it was asked.
        condition: its label; empty where it was asked outside of conditions.
        alpha: Cronbach's alpha with Feldt's interval; empty where refused.
        without: alpha with each item left out, from least to largest.
        items, rows, participants: how many entered: rows are answers.
        refused: why there is none, or empty.
    """

    name: str
    condition: str
    alpha: str
    without: str
    items: int
    rows: int
    participants: int
    refused: str


@dataclasses.dataclass(frozen=True, slots=True)
class PairRow:
    """One pair of three or more conditions on one scale."""

    name: str
    test: EffectResult


def name(row: ScaleRow) -> str:
    """Return a scale's name in words."""
    return scale_name(row.asked.instrument, row.asked.scale)


def scale_name(instrument: str, scale: str) -> str:
    """Return a scale's name in words, after its instrument's where they share none."""
    alike = set(instrument.split("_")) & set(scale.split("_"))
    return _words(scale) if alike else f"{_words(instrument)}: {_words(scale)}"


def full_name(row: ScaleRow) -> str:
    """Return a scale's name and when it was asked: "Trust (after reveal)"."""
    return f"{name(row)} ({_when(row)})"


def figure(results: StudyResults) -> Drawing | None:
    """Draw the scores; None if nobody has one under every condition."""
    rows = [row for row in results.scales if row.cells.n]
    if not rows:
        return None
    labels = results.labels if results.facts.levels else ()
    return score_dots("scores", rows, labels, [(name(row), _when(row)) for row in rows])


def finding(results: StudyResults) -> str:
    """Say on which scales a difference was detected, and on which not."""
    found: dict[str, list[str]] = {"differs": [], "none": [], "refused": []}
    two = len(results.labels) == 2
    for row in (row for row in results.scales if row.compared):
        p, test = row.holm_p if two else row.holm_f_p, row.f_test
        if p is None or isinstance(test, Refusal):
            found["refused"].append(full_name(row))
        elif p >= ALPHA:
            found["none"].append(full_name(row))
        elif test.estimate is None:
            found["differs"].append(full_name(row))
        else:
            way = "higher" if test.estimate > 0 else "lower"
            shown = number(abs(test.estimate))
            found["differs"].append(f"{full_name(row)}, {shown} {way} under {results.labels[1]}")
    sentences = []
    if found["differs"]:
        sentences.append(f"Conditions differed on {listed(found['differs'])}.")
    if found["none"]:
        sentences.append(f"No difference was detected on {listed(found['none'])}.")
    if found["differs"] or found["none"]:
        how = "the exact Wilcoxon test" if two else "the corrected F test"
        sentences.append(f"This goes by {how} with Holm’s adjustment over all scales.")
    if found["refused"]:
        sentences.append(f"Not tested: {listed(found['refused'])}.")
    return " ".join(sentences)


def compared(results: StudyResults) -> list[ScaleRow]:
    """Return the scales that were asked under conditions."""
    return [row for row in results.scales if row.compared]


def pairs(results: StudyResults) -> list[PairRow]:
    """Return every pair of three or more conditions that was tested; none of crossed factors."""
    if results.scale_effects:
        return []
    return [
        PairRow(full_name(row), dataclasses.replace(test, name=pair_label(results, test.name)))
        for row in results.scales
        for test in row.contrasts
        if isinstance(test, EffectResult)
    ]


def pair_label(results: StudyResults, name: str) -> str:
    """Write a pair of conditions by their labels: "Assisted − Manual"."""
    return " − ".join(results.facts.label(part) for part in name.split(" − "))


def reliability(results: StudyResults) -> list[AlphaRow]:
    """Lay out Cronbach's alpha of every scale."""
    return [
        _alpha(row, results.facts.label(level) if level else "", alpha)
        for row in results.scales
        for level, alpha in row.reliability
    ]


def refusals(results: StudyResults) -> list[Refusal]:
    """Return the comparisons that were refused, each reason once."""
    unique: dict[str, Refusal] = {}
    for row in results.scales:
        if row.compared and isinstance(row.f_test, Refusal):
            refusal = Refusal(full_name(row), row.f_test.reason)
            unique.setdefault(refusal.name, refusal)
    return list(unique.values())


def asked_text(results: StudyResults) -> str:
    """Name the instruments with their versions."""
    seen: dict[str, str] = {}
    for row in results.scales:
        version = f"version {row.asked.version}" if row.asked.version else "version not recorded"
        seen.setdefault(row.asked.instrument, f"{row.asked.instrument} ({version})")
    count = counted(len(seen), "scored instrument")
    return f"{count}: {listed(list(seen.values()))}."


def _alpha(row: ScaleRow, condition: str, found: Reliability | Refusal) -> AlphaRow:
    if isinstance(found, Refusal):
        items = len(row.asked.items)
        return AlphaRow(full_name(row), condition, "", "", items, 0, 0, found.reason)
    without = sorted(found.without_item.values())
    return AlphaRow(
        name=full_name(row),
        condition=condition,
        alpha=f"{fraction(found.alpha)} {_bounds(found.interval)}",
        without=f"{fraction(without[0])} to {fraction(without[-1])}" if without else "",
        items=len(found.items),
        rows=found.rows,
        participants=found.participants,
        refused="",
    )


def _bounds(bounds: Interval) -> str:
    return f"[{fraction(bounds.low)}, {fraction(bounds.high)}]"


def _when(row: ScaleRow) -> str:
    return row.asked.occasion.replace("_", " ")


def _words(text: str) -> str:
    words = text.replace("_", " ")
    known = {"sus": "SUS", "tlx": "TLX", "nasa": "NASA"}
    parts = [known.get(word, word) for word in words.split()]
    joined = " ".join(parts)
    return joined[:1].upper() + joined[1:]
