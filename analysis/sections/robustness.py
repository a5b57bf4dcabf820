"""Robustness: one participant fewer, another order, another kind of evidence."""

from __future__ import annotations

from analysis.formatting import fraction, number, p_value
from analysis.results import StudyResults
from analysis.statistics.bayes_factor import BayesFactor
from analysis.statistics.crossover import Crossover
from analysis.statistics.leave_one_out import LeaveOneOut
from analysis.statistics.result import EffectResult, Refusal

LARGEST_SHOWN = 1e6


def findings(results: StudyResults) -> list[str]:
    """Say, a sentence or two each, what leaving out and the Bayes factor show."""
    found = results.robustness
    if found is None:
        return []
    sentences = []
    if isinstance(found.left_out, LeaveOneOut):
        sentences.append(_left_out(found.left_out))
    if isinstance(found.bayes, BayesFactor):
        sentences.append(_bayes(found.bayes))
    return sentences


def order_tests(results: StudyResults) -> list[EffectResult]:
    """Return condition adjusted for period, period and carry-over, where computed."""
    found = results.robustness
    if found is None or not isinstance(found.orders, Crossover):
        return []
    return [outcome for outcome in found.orders.outcomes if isinstance(outcome, EffectResult)]


def refusals(results: StudyResults) -> list[Refusal]:
    """Return what was not computed, and why."""
    found = results.robustness
    if found is None:
        reason = (
            "These tests look at the difference of two conditions from other sides; here it "
            "could not be tested in the first place, or there are not two conditions."
        )
        return [Refusal("Robustness", reason)]
    refused = list(found.refusals)
    if isinstance(found.orders, Crossover):
        refused += [outcome for outcome in found.orders.outcomes if isinstance(outcome, Refusal)]
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
