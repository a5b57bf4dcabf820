"""Whether the participants' differences look normal: what the paired t test assumes."""

from __future__ import annotations

from scipy import stats

from analysis.statistics.cells import Cells
from analysis.statistics.pairs import differences
from analysis.statistics.result import Check, Refusal

LARGEST_N = 5000


def shapiro_wilk(
    cells: Cells, name: str = "Shapiro-Wilk test of the differences"
) -> Check | Refusal:
    """Test the differences of two conditions for normality.

    Source: Royston (1995), Applied Statistics 44, 547-551, as in R's `shapiro.test`.
    """
    found = differences(cells, name)
    if isinstance(found, Refusal):
        return found
    if cells.n > LARGEST_N:
        reason = f"The test's p is known up to {LARGEST_N} participants; these are {cells.n}."
        return Refusal(name, reason, cells.excluded)
    w, p = stats.shapiro(found - found.mean())
    note = "A small p says that the differences are not normal; a large one does not say they are."
    return Check(name, "W", float(w), float(p), note=note)
