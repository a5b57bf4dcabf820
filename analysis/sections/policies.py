"""Phase four: each condition's policy on its own."""

from __future__ import annotations

from analysis.figures.paired_means import paired_means
from analysis.figures.svg import Drawing
from analysis.formatting import NO_BREAK, counted, number
from analysis.results import StudyResults
from analysis.statistics.result import Refusal


def figure(results: StudyResults) -> Drawing | None:
    """Draw policies' rewards joined; None without phase four."""
    cells = results.phase_four.cells
    if cells.n == 0 or len(cells.levels) < 2:
        return None
    hints = []
    for row in results.phase_four.rows:
        low, high = (
            (row.demonstrations[0], row.demonstrations[-1]) if row.demonstrations else (0, 0)
        )
        hints.append(f"{low} to {high} demonstrations" if row.demonstrations else "")
    return paired_means(
        "policies",
        cells,
        results.labels,
        hints,
        measure="Policy reward per trial",
        unit="points, nobody operating",
    )


def finding(results: StudyResults) -> str:
    """Say what was found about the policies, in one sentence."""
    four = results.phase_four
    test, labels = four.test, results.labels
    if isinstance(test, Refusal):
        return f"Policy reward was not tested. {test.reason}"
    if test.estimate is None or test.interval is None:
        return "Policies of several conditions were compared."
    reach = f"95%{NO_BREAK}CI {number(test.interval.low, 1)} to {number(test.interval.high, 1)}"
    difference = f"{number(test.estimate, 1)} points a trial, {reach}"
    if test.interval.holds(0.0):
        return (
            f"No difference was detected between the policies of {labels[0]} and {labels[1]}: "
            f"{difference}."
        )
    way = "more" if test.estimate > 0 else "less"
    return (
        f"Policies fitted with the demonstrations of {labels[1]} earned {way} than those of "
        f"{labels[0]}: {difference}."
    )


def starts(results: StudyResults) -> str:
    """Say whether policies were compared from the same start states."""
    four = results.phase_four
    if four.cells.n == 0:
        return ""
    return (
        f"Start states were identical across conditions for {four.same_starts} of "
        f"{counted(four.cells.n, 'participant')}."
    )
