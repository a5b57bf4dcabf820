"""The primary test on other choices of rows: without exclusions, as treated, whole sessions."""

from __future__ import annotations

import dataclasses

import pandas as pd

from analysis.measures import AnalysedData
from analysis.robustness import reward_tests
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.result import EffectResult, Outcome


@dataclasses.dataclass(frozen=True, slots=True)
class Variant:
    """The primary test once more, on other rows.

    Attributes:
        name: which rows, in a few words.
        reason: why one would want it, a sentence.
        same: whether these are the very rows of the primary test, so that nothing is tested anew.
        outcome: the result.
    """

    name: str
    reason: str
    same: bool
    outcome: Outcome


def variants(
    data: AnalysedData, cells: Cells, primary: Outcome, complete: frozenset[str]
) -> tuple[Variant, ...]:
    """Compute the variants, in the order in which they are shown.

    Which test is run follows from the rows by the rule that chose the primary one.

    Args:
        data: what the primary test rests on.
        cells: its participant-by-condition means.
        primary: its outcome.
        complete: participants whose sessions ran to their end.
    """
    whole = data.trials[data.trials["participant"].isin(complete)]
    choices = (
        (
            "without exclusions",
            data.unruled_trials,
            "No rule of the protocol is applied, of participants or of trials.",
        ),
        (
            "as treated",
            data.treated,
            "Each trial counts under the condition that ran; trials that ran none are left out.",
        ),
        ("complete sessions only", whole, "Sessions that ended early are left out."),
    )
    same = (
        len(data.unruled_trials) == len(data.trials),
        data.departures.empty,
        len(whole) == len(data.trials),
    )
    return tuple(
        Variant(name, reason, unchanged, primary if unchanged else _again(rows, cells, name))
        for (name, rows, reason), unchanged in zip(choices, same, strict=True)
    )


def _again(rows: pd.DataFrame, cells: Cells, name: str) -> Outcome:
    made = cell_means(rows, "team_reward", cells.levels, what="complete trials")
    outcome = reward_tests(rows, made).primary
    named = f"{outcome.name}, {name}"
    if isinstance(outcome, EffectResult):
        return dataclasses.replace(outcome, name=named, role="sensitivity")
    return dataclasses.replace(outcome, name=named)
