"""Ratings: bars, the table as the paper lays it out, the tests recommended."""

from __future__ import annotations

import dataclasses

from analysis.figures.ratings import item_label, rating_bars
from analysis.figures.svg import Drawing
from analysis.formatting import listed, number
from analysis.results import StudyResults
from analysis.statistics.likert import LikertRow
from analysis.statistics.result import ALPHA, EffectResult, Refusal


def label(row: LikertRow) -> str:
    """Return a row's name: Q1, or Q1* after the reveal."""
    return item_label(row.item, row.occasion)


def figure(results: StudyResults) -> Drawing | None:
    """Draw the answers; None if nobody answered under every condition."""
    if not any(row.cells.n for row in results.ratings):
        return None
    return rating_bars("ratings", results.ratings, results.labels, results.facts.items)


def finding(results: StudyResults) -> str:
    """Say for which items a difference was detected, and for which not.

    Detected is what the recommended test finds after Holm's adjustment: Wilcoxon's of two
    conditions, the corrected F of more.
    """
    found: dict[str, list[str]] = {"higher": [], "lower": [], "none": [], "refused": []}
    found["differs"] = []
    two = len(results.labels) == 2
    for row in results.ratings:
        test, p = row.f_test, row.holm_p if two else row.holm_f_p
        if isinstance(test, Refusal) or p is None:
            found["refused"].append(label(row))
        elif p >= ALPHA:
            shown = "" if test.estimate is None else f" ({number(test.estimate)} points)"
            found["none"].append(f"{label(row)}{shown}")
        elif test.estimate is None:
            found["differs"].append(label(row))
        else:
            found["higher" if test.estimate > 0 else "lower"].append(label(row))
    other = results.labels[1] if two else "the conditions"
    sentences = []
    if found["differs"]:
        sentences.append(f"Conditions were rated unlike on {listed(found['differs'])}.")
    if found["higher"]:
        sentences.append(f"{other} was rated higher on {listed(found['higher'])}.")
    if found["lower"]:
        sentences.append(f"{other} was rated lower on {listed(found['lower'])}.")
    if found["none"]:
        sentences.append(f"No difference was detected on {listed(found['none'])}.")
    if any(found[key] for key in ("higher", "lower", "none", "differs")):
        how = "the exact Wilcoxon test" if two else "the corrected F test"
        sentences.append(f"This goes by {how} with Holm’s adjustment.")
    if found["refused"]:
        sentences.append(f"Not tested: {listed(found['refused'])}.")
    return " ".join(sentences)


def paper_heading(results: StudyResults) -> str:
    """Return the degrees of freedom if all rows share them: "(1, 11)"."""
    tests = [row.f_test for row in results.ratings if isinstance(row.f_test, EffectResult)]
    pairs = {(test.df1, test.df2) for test in tests}
    if len(pairs) != 1:
        return ""
    df1, df2 = pairs.pop()
    return f"({df1:g}, {df2:g})"


def refusals(results: StudyResults) -> list[Refusal]:
    """Return the refused tests of ratings, each reason once."""
    unique: dict[str, Refusal] = {}
    for row in results.ratings:
        if isinstance(row.f_test, Refusal):
            unique.setdefault(
                f"{label(row)}{row.f_test.reason}", Refusal(label(row), row.f_test.reason)
            )
    return list(unique.values())


def pairs(results: StudyResults) -> list[tuple[str, EffectResult]]:
    """Return each item with the test of each pair of three or more conditions.

    None where conditions cross factors: these take the place of pairs, of which there are many.
    """
    if results.rating_effects:
        return []
    found = []
    for row in results.ratings:
        for test in row.pairs:
            if isinstance(test, EffectResult):
                named = " − ".join(results.facts.label(part) for part in test.name.split(" − "))
                found.append((label(row), dataclasses.replace(test, name=named)))
    return found


def questions(results: StudyResults) -> str:
    """Quote the items."""
    items = results.facts.items
    asked = sorted({row.item for row in results.ratings})
    return " ".join(f"{name.upper()}: “{items[name].text}.”" for name in asked if name in items)
