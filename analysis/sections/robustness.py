"""Robustness: one participant fewer, another order, another kind of evidence."""

from __future__ import annotations

from analysis.formatting import fraction, interval, number, p_text, p_value
from analysis.results import StudyResults
from analysis.statistics.bayes_factor import BayesFactor
from analysis.statistics.crossover import Crossover
from analysis.statistics.latin_square import LatinSquare
from analysis.statistics.leave_one_out import LeaveOneOut
from analysis.statistics.result import ALPHA, EffectResult, Refusal

LARGEST_SHOWN = 1e6


def findings(results: StudyResults) -> list[str]:
    """Say, a sentence or two each, what leaving out, Bayes factor and equivalence show."""
    found = results.robustness
    if found is None:
        return []
    sentences = []
    if isinstance(found.left_out, LeaveOneOut):
        sentences.append(_left_out(found.left_out))
    if isinstance(found.bayes, BayesFactor):
        sentences.append(_bayes(found.bayes))
    if isinstance(found.equivalence, EffectResult):
        sentences.append(_equivalence(found.equivalence, results.facts.equivalence_bound))
    return sentences


def order_tests(results: StudyResults) -> list[EffectResult]:
    """Return condition adjusted for period, period and carry-over, where computed."""
    found = results.order_tests
    if not isinstance(found, Crossover | LatinSquare):
        return []
    return [outcome for outcome in found.outcomes if isinstance(outcome, EffectResult)]


def order_design(results: StudyResults) -> str:
    """Say what the orders make of the design, for the table's caption."""
    if isinstance(results.order_tests, LatinSquare):
        kind = "Balanced" if results.order_tests.balanced else "Not quite balanced"
        return (
            f"{kind} Latin squares: condition, period and carry-over of the condition before, each "
            "adjusted for the others."
        )
    return (
        "The two orders as a crossover: condition and period adjusted for each other, and "
        "carry-over, in points a trial."
    )


def refusals(results: StudyResults) -> list[Refusal]:
    """Return what was not computed, and why."""
    found, orders = results.robustness, results.order_tests
    if found is None and orders is None:
        reason = (
            "These tests look at the difference of conditions from other sides; here it could "
            "not be tested in the first place."
        )
        return [Refusal("Robustness", reason)]
    refused = list(found.refusals) if found is not None else []
    if isinstance(orders, Refusal):
        refused.append(orders)
    elif orders is not None:
        refused += [outcome for outcome in orders.outcomes if isinstance(outcome, Refusal)]
    return refused


def _left_out(left: LeaveOneOut) -> str:
    low, high = (number(value) for value in left.estimates)
    least, most = (p_value(value) for value in left.p_values)
    sign = "keeps its sign" if left.same_sign else "changes its sign"
    return (
        f"With each participant left out in turn, the difference {sign}: it lies between {low} and "
        f"{high} points, and p between {least} and {most}. Leaving out {left.most_influential} "
        "changes it most."
    )


def _equivalence(test: EffectResult, bound: float | None) -> str:
    """Say whether the difference is smaller than what would matter."""
    shown = number(bound) if bound is not None else ""
    found = (
        f"The conditions are equivalent within {shown} points"
        if test.p < ALPHA
        else f"Equivalence within {shown} points was not shown"
    )
    reach = f"; 90% CI {interval(test.interval)}" if test.interval is not None else ""
    return (
        f"{found}, the bound that the protocol states: two one-sided tests, "
        f"t({test.df2:g}) = {number(test.statistic)}, {p_text(test.p)}{reach}."
    )


def _bayes(bayes: BayesFactor) -> str:
    favours, against = "a difference", "no difference"
    if bayes.bf10 < 1:
        favours, against = against, favours
    factor = max(bayes.bf10, 1 / bayes.bf10) if bayes.bf10 > 0 else float("inf")
    shown = number(factor, 1) if factor < LARGEST_SHOWN else "more than a million"
    return (
        f"The data are {shown} times as likely under {favours} as under {against} (Bayes factor "
        f"with a Cauchy prior of scale {fraction(bayes.scale)} on the standardised difference)."
    )
