"""Team reward: figures, the table of tests, orders."""

from __future__ import annotations

import dataclasses

from analysis.figures.forest import ForestGroup, forest
from analysis.figures.paired_means import paired_means
from analysis.figures.svg import Drawing
from analysis.figures.trial_curves import trial_curves
from analysis.formatting import counted, in_words, listed, number
from analysis.results import StudyResults
from analysis.statistics.order_effects import period_means
from analysis.statistics.result import EffectResult, Outcome, Refusal

HINTS = {
    "manual": "operator chooses",
    "assisted": "scorer switches",
    "suggested": "scorer suggests",
}


@dataclasses.dataclass(frozen=True, slots=True)
class TestGroup:
    """Tests under one heading of the table."""

    heading: str
    kind: str
    results: tuple[EffectResult, ...]


def test_groups(results: StudyResults) -> list[TestGroup]:
    """Group the tests that were computed; empty groups are left out."""
    groups = [
        ("Primary", "primary", (results.primary,)),
        ("Sensitivity: the same question, other assumptions", "sensitivity", results.sensitivity),
        ("The primary test on other rows", "sensitivity", _other_rows(results)),
        ("The paper’s form, for comparison only", "comparison", results.comparison),
    ]
    made = [TestGroup(heading, kind, _computed(outcomes)) for heading, kind, outcomes in groups]
    return [group for group in made if group.results]


def refusals(results: StudyResults) -> list[Refusal]:
    """Return the tests of team reward that were refused."""
    outcomes = (
        results.primary,
        *results.sensitivity,
        *_other_rows(results),
        *results.comparison,
    )
    return [outcome for outcome in outcomes if isinstance(outcome, Refusal)]


def figure(results: StudyResults) -> Drawing | None:
    """Draw participants' means joined; None with fewer than two conditions or nobody."""
    if results.cells.n == 0 or len(results.cells.levels) < 2:
        return None
    hints = [HINTS.get(c.allocation, c.allocation) for c in results.facts.conditions]
    trials = results.facts.planned_trials
    unit = f"points, mean of {counted(trials, 'trial')}" if trials else "points"
    return paired_means(
        "reward",
        results.cells,
        results.labels,
        hints,
        measure="Mean team reward per trial",
        unit=unit,
    )


def _other_rows(results: StudyResults) -> tuple[Outcome, ...]:
    return tuple(variant.outcome for variant in results.variants if not variant.same)


def forest_figure(results: StudyResults) -> Drawing | None:
    """Draw all models of the difference; None unless two conditions were tested."""
    if len(results.labels) != 2 or isinstance(results.primary, Refusal):
        return None
    groups = [
        ForestGroup(group.heading, group.kind, tuple(r for r in group.results if _drawable(r)))
        for group in test_groups(results)
    ]
    return forest("forest", groups, results.labels)


def forest_finding(results: StudyResults) -> str:
    """Say whether the models agree on the sign, in one sentence."""
    outcomes = (results.primary, *results.sensitivity, *_other_rows(results))
    drawn = [o for o in outcomes if isinstance(o, EffectResult) and _drawable(o)]
    holding = [o for o in drawn if o.interval is not None and o.interval.holds(0.0)]
    if len(drawn) < 2:
        return "One model only."
    if not holding:
        return "Every model's interval leaves zero out."
    if len(holding) == len(drawn):
        return "Every model's interval holds zero."
    return f"{in_words(len(holding), capital=True)} of {in_words(len(drawn))} intervals hold zero."


def _drawable(result: EffectResult) -> bool:
    return result.estimate is not None and result.interval is not None and not result.unit


def curves(results: StudyResults) -> Drawing | None:
    """Draw reward by trial; None without a trial."""
    trials = results.data.trials
    if not len(trials) or not results.orders:
        return None
    used = trials[trials["participant"].isin(results.cells.participants)]
    return trial_curves("curves", used, results.data.orders, results.facts.levels, results.labels)


def order_finding(results: StudyResults) -> str:
    """Say what the orders used were, in a sentence."""
    people: dict[tuple[str, ...], set[str]] = {}
    for row in results.orders:
        people.setdefault(row.order, set()).update(row.participants)
    if not people:
        return "No complete trial shows an order."
    parts = []
    for order, who in sorted(people.items()):
        names = " then ".join(results.facts.label(name) for name in order)
        people_text = "participant" if len(who) == 1 else "participants"
        parts.append(f"{in_words(len(who))} {people_text} ran {names}")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def period_finding(results: StudyResults) -> str:
    """Give the mean of each period, every participant counting once."""
    means = period_means(results.orders)
    if len(means) < 2:
        return ""
    shown = [f"{number(mean, 1)} in period {period}" for period, mean in means.items()]
    tested = "; orders are tested under Robustness" if results.order_tests is not None else ""
    return f"Mean team reward was {listed(shown)}{tested}."


def order_caption(results: StudyResults) -> str:
    """Open the caption with what the means by order show."""
    by_order: dict[tuple[str, ...], dict[str, float]] = {}
    for row in results.orders:
        by_order.setdefault(row.order, {})[row.condition] = row.mean
    levels = results.facts.levels
    complete = [means for means in by_order.values() if set(levels) <= set(means)]
    if len(levels) != 2 or not complete:
        return "Team reward by trial."
    wins = sum(means[levels[1]] > means[levels[0]] for means in complete)
    reference, other = results.labels
    if wins == len(complete):
        where = "both orders" if wins == 2 else "every order" if wins > 2 else "the order used"
        return f"Mean reward was higher under {other} in {where}."
    if wins == 0:
        return f"Mean reward was not higher under {other} in any order."
    return f"Whether {other} or {reference} had the higher mean depended on the order."


def _computed(outcomes: tuple[Outcome, ...]) -> tuple[EffectResult, ...]:
    return tuple(outcome for outcome in outcomes if isinstance(outcome, EffectResult))
