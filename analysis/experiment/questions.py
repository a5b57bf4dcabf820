"""What is asked of an experiment: H1, H2, the data's impact and the correction round.

The hypotheses are in our words: H1, that scores learned from free choices in a small fleet by
Luce's model say whom the user would choose in the large one, better than a classifier's; H2,
that a fleet helped by them earns more. The paper's third measure is what a policy learns from
the demonstrations that were gathered so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pandas as pd

from analysis.experiment.contrasts import Contrast, adjusted, by_scorer, paired
from analysis.experiment.frames import CORRECTED, NONE, Experiment

PREDICTION = "H1: whom the user would choose"
REWARD = "H2: what the fleet earns"
IMPACT = "Data impact: what the policy learns"
CORRECTION = "Beyond the paper: the correction round, at equal data"


def hypotheses(experiment: Experiment) -> dict[str, list[Contrast]]:
    """Return the contrasts by heading; Holm's p is within each heading."""
    found = {
        PREDICTION: adjusted(list(_prediction(experiment))),
        REWARD: adjusted(list(_reward(experiment))),
        IMPACT: adjusted(list(_impact(experiment))),
        CORRECTION: adjusted(list(_correction(experiment))),
    }
    return {heading: contrasts for heading, contrasts in found.items() if contrasts}


def runs_at(experiment: Experiment, dwell: int) -> pd.DataFrame:
    """Return the runs of a dwell, and the fleet that nobody helps, which has none."""
    runs = experiment.tables["runs"]
    return runs[(runs["dwell"] == dwell) | (runs["scorer"] == NONE)]


def policies_at(experiment: Experiment, dwell: int) -> pd.DataFrame:
    """Return the main policies of a dwell, and phase one's."""
    policies = experiment.tables["policies"]
    main = (policies["dwell"] == dwell) & (policies["training"] == experiment.training)
    return policies[main | (policies["scorer"] == NONE)]


def _prediction(experiment: Experiment) -> Iterator[Contrast | None]:
    luce, classifier = experiment.luce, experiment.classifier
    if luce is None or classifier is None:
        return
    first, *others = experiment.dwells
    frame = runs_at(experiment, first)
    for measure, words in (
        ("own_agreement", f"agreement, own fleet’s states, dwell {first}"),
        ("reference_agreement", "agreement, ground truth’s states"),
    ):
        yield paired("H1", words, "share", by_scorer(frame, measure), luce, classifier)
    for dwell in others:
        wide = by_scorer(runs_at(experiment, dwell), "own_agreement")
        words = f"agreement, own fleet’s states, dwell {dwell}"
        yield paired("H1", words, "share", wide, luce, classifier)


def _reward(experiment: Experiment) -> Iterator[Contrast | None]:
    return _luce_against_others(experiment, "H2", runs_at, "team_reward", "team reward")


def _impact(experiment: Experiment) -> Iterator[Contrast | None]:
    return _luce_against_others(
        experiment, "impact", policies_at, "policy_reward", "policy’s reward"
    )


def _luce_against_others(
    experiment: Experiment,
    question: str,
    rows_at: Callable[[Experiment, int], pd.DataFrame],
    measure: str,
    words: str,
) -> Iterator[Contrast | None]:
    """Yield Luce's scorer against each other one, in points, dwell by dwell."""
    if experiment.luce is None:
        return
    for dwell in experiment.dwells:
        wide = by_scorer(rows_at(experiment, dwell), measure)
        named = f"{words}, dwell {dwell}"
        for other in experiment.scorers:
            if other not in (experiment.luce, CORRECTED):
                yield paired(question, named, "points", wide, experiment.luce, other)


def _correction(experiment: Experiment) -> Iterator[Contrast | None]:
    part = experiment.protocol.get("correction")
    if part is None:
        return
    first = experiment.dwells[0]
    wide = by_scorer(runs_at(experiment, first), "reference_agreement")
    words = "agreement, ground truth’s states"
    yield paired("correction", words, "share", wide, CORRECTED, part["scorer"])
    for dwell in experiment.dwells:
        for measure, words, unit in (
            ("own_agreement", "agreement, own fleet’s states", "share"),
            ("team_reward", "team reward", "points"),
        ):
            wide = by_scorer(runs_at(experiment, dwell), measure)
            named = f"{words}, dwell {dwell}"
            yield paired("correction", named, unit, wide, CORRECTED, part["scorer"])
