"""The primary test on other choices of rows: without exclusions, as treated, whole sessions."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from analysis.measures import AnalysedData
from analysis.recordings import StudyRecordings
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.result import Outcome
from analysis.statistics.rm_anova import rm_anova


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
    study: StudyRecordings, data: AnalysedData, cells: Cells, primary: Outcome
) -> tuple[Variant, ...]:
    """Compute the variants, in the order in which they are shown.

    Args:
        study: the recordings.
        data: what the primary test rests on.
        cells: its participant-by-condition means.
        primary: its outcome.
    """
    levels = cells.levels

    def again(name: str, rows: object, reason: str, *, same: bool) -> Variant:
        outcome = primary
        if not same:
            made = cell_means(rows, "team_reward", levels, what="complete trials")  # type: ignore[arg-type]
            outcome = rm_anova(made, f"Participant means, {name}", "sensitivity")
        return Variant(name, reason, same, outcome)

    whole = [s.opened.participant for s in study.sessions if s.complete]
    return (
        again(
            "nobody excluded",
            data.all_trials,
            "No rule of the protocol is applied.",
            same=not data.excluded,
        ),
        again(
            "as treated",
            data.treated,
            "Each trial counts under the condition that ran; trials that ran none are left out.",
            same=not len(data.departures),
        ),
        _complete_sessions(cells, whole, primary),
    )


def _complete_sessions(cells: Cells, whole: Sequence[str], primary: Outcome) -> Variant:
    name = "complete sessions only"
    reason = "Sessions that ended early are left out."
    kept = [place for place, who in enumerate(cells.participants) if who in set(whole)]
    if len(kept) == cells.n:
        return Variant(name, reason, same=True, outcome=primary)
    fewer = dataclasses.replace(
        cells,
        participants=tuple(cells.participants[place] for place in kept),
        means=cells.means[kept],
        counts=cells.counts[kept],
    )
    outcome = rm_anova(fewer, f"Participant means, {name}", "sensitivity")
    return Variant(name, reason, same=False, outcome=outcome)
