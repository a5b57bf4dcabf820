"""Three or more conditions: their pairs, and the factors that they cross."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from markupsafe import Markup

from analysis.figures.forest import ForestGroup, forest
from analysis.figures.interaction import interaction
from analysis.figures.paired_means import inferred
from analysis.figures.svg import Drawing
from analysis.formatting import NO_BREAK, counted, listed, number
from analysis.results import StudyResults
from analysis.statistics.result import ALPHA, EffectResult, Outcome, Refusal


def pairs(results: StudyResults) -> list[EffectResult]:
    """Return the pairs of three or more conditions that were tested, by their labels."""
    return [_named(results, test) for test in _computed(results.contrasts)]


def pairs_figure(results: StudyResults) -> Drawing | None:
    """Draw the differences of all pairs; None where there are none."""
    found = pairs(results)
    if not found:
        return None
    how = "mixed model of trials" if results.by_trial else "participant means"
    group = ForestGroup(f"Pairs of conditions, {how}", "sensitivity", tuple(found))
    return forest("pairs", [group], ())


def pairs_finding(results: StudyResults) -> str:
    """Say which pairs differ after Holm's adjustment."""
    found = pairs(results)
    differ = [test for test in found if (test.p_adjusted or 0.0) < ALPHA]
    count = counted(len(found), "pair")
    if not differ:
        return f"None of {count} of conditions differs after Holm’s adjustment."
    shown = [f"{test.name} {number(test.estimate or 0.0, 1)}" for test in differ]
    many = f"{len(differ)} {'differs' if len(differ) == 1 else 'differ'}"
    return f"Of {count} of conditions, {many} after Holm’s adjustment: {listed(shown)}."


def effects(results: StudyResults) -> tuple[EffectResult, ...]:
    """Return main effects and interactions that words go by; none where nothing is crossed."""
    if results.factorial is None:
        return ()
    return results.factorial.effects(by_trial=results.by_trial)


def other_effects(results: StudyResults) -> tuple[EffectResult, ...]:
    """Return the same effects by the other test."""
    if results.factorial is None:
        return ()
    return results.factorial.effects(by_trial=not results.by_trial)


def effects_in_words(results: StudyResults) -> str:
    """Say which effects were detected, after Holm's adjustment over them."""
    found = [_plain(effect) for effect in effects(results)]
    differ = [effect for effect in found if (effect.p_adjusted or 0.0) < ALPHA]
    rest = [effect.name for effect in found if effect not in differ]
    sentences = []
    for effect in differ:
        if "×" in effect.name:
            sentences.append(f"{_first_upper(effect.name.lower())} interacted{_by(effect)}.")
        else:
            way = _way(results, effect)
            sentences.append(f"Team reward differed by {effect.name.lower()}{_by(effect, way)}.")
    if rest:
        names = [_spoken(results, name) for name in rest]
        sentences.append(f"No effect was detected of {_either(names)}.")
    return " ".join(sentences)


def factors_in_words(results: StudyResults) -> str:
    """Describe the factors: "Allocation (Manual, Assisted) crossed with Fleet size (...)"."""
    crossing = results.facts.crossing
    if crossing is None:
        return ""
    parts = [f"{f.label.lower()} ({', '.join(f.level_labels)})" for f in crossing.factors]
    return _first_upper(" crossed with ".join(parts))


def interaction_figure(results: StudyResults) -> Drawing | None:
    """Draw crossed factors; None where nothing is crossed, or nobody has every condition."""
    found, cells = results.factorial, results.cells
    if found is None or cells.n == 0:
        return None
    return interaction("interaction", found.crossing, cells)


def interaction_caption(results: StudyResults) -> Markup:
    """Say what the panels of the interaction figure are."""
    if results.factorial is None:
        return Markup("")
    factors = results.factorial.crossing.factors
    lines, places = factors[:2]
    interval = "95% CI" if inferred(results.cells) else ""
    others = listed(list(lines.level_labels[1:]))
    shown = f"{others} minus {lines.level_labels[0]}"
    if len(lines.levels) > 2:
        shown = f"from left to right {others}, each minus {lines.level_labels[0]}"
    text = Markup(
        "<b>{}</b>, Means{}: a line for each level of {}, over {}; lines that are not parallel are "
        "an interaction. <b>{}</b>, Each participant’s difference at each level of {}: {}, with "
        "mean{}."
    ).format(
        "a" if len(factors) == 2 else "Left",
        f" with {interval}s between participants" if interval else "",
        lines.label.lower(),
        places.label.lower(),
        "b" if len(factors) == 2 else "Right",
        places.label.lower(),
        shown,
        f" and {interval}" if interval else "",
    )
    if len(factors) > 2:
        text += Markup(
            " A row for each level of {}, on the same axes: lines that differ between rows are an "
            "interaction of all three."
        ).format(factors[2].label.lower())
    return text


def simple(results: StudyResults) -> list[EffectResult]:
    """Return the simple effects that were tested."""
    return list(_computed(results.factorial.simple)) if results.factorial else []


def refusals(results: StudyResults) -> list[Refusal]:
    """Return what was refused of factors, each reason once."""
    if results.factorial is None:
        return []
    unique: dict[str, Refusal] = {}
    for outcome in (*results.factorial.means, *results.factorial.trials, *results.factorial.simple):
        if isinstance(outcome, Refusal):
            unique.setdefault(outcome.reason, outcome)
    return list(unique.values())


def _spoken(results: StudyResults, name: str) -> str:
    crossing = results.facts.crossing
    two = crossing is not None and len(crossing.factors) == 2
    return "the interaction" if "×" in name and two else name.lower()


def _either(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} or {names[-1]}" if len(names) > 1 else "".join(names)


def _named(results: StudyResults, test: EffectResult) -> EffectResult:
    name = " − ".join(results.facts.label(part) for part in test.name.split(" − "))
    return dataclasses.replace(test, name=name)


def _plain(effect: EffectResult) -> EffectResult:
    return dataclasses.replace(effect, name=effect.name.removesuffix(", mixed model"))


def _way(results: StudyResults, effect: EffectResult) -> str:
    """Name the levels whose difference a main effect's estimate is: "12 robots minus 4 robots"."""
    for factor in results.facts.crossing.factors if results.facts.crossing else ():
        if factor.label == effect.name and len(factor.levels) == 2:
            return f"{factor.level_labels[1]} minus {factor.level_labels[0]}: "
    return ""


def _by(effect: EffectResult, way: str = "") -> str:
    if effect.estimate is None or effect.interval is None or effect.unit:
        return ""
    low, high = number(effect.interval.low, 1), number(effect.interval.high, 1)
    reach = f"95%{NO_BREAK}CI {low} to {high}"
    return f" ({way}{number(effect.estimate, 1)} points a trial, {reach})"


def _computed(outcomes: Sequence[Outcome]) -> tuple[EffectResult, ...]:
    return tuple(outcome for outcome in outcomes if isinstance(outcome, EffectResult))


def _first_upper(text: str) -> str:
    return text[:1].upper() + text[1:]
