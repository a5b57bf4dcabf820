"""Sign-flip permutation test of paired differences.

Under the null hypothesis a participant's difference is as likely positive as negative, so that
every pattern of signs is equally likely (Fisher 1935, The Design of Experiments, section 21).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from analysis.statistics.cells import Cells
from analysis.statistics.pairs import differences
from analysis.statistics.result import EffectResult, Outcome, Refusal

EXACT_UP_TO = 20
DRAWS = 99_999


def sign_flip(cells: Cells, name: str = "Sign-flip permutation", seed: int = 20_260_101) -> Outcome:
    """Test the mean difference over all 2^n patterns of signs, or a random sample of them.

    Args:
        cells: participant means under two conditions.
        name: what the tables call the test.
        seed: of the sample of patterns where n > 20; the p value is then (b + 1) / (m + 1)
            (Phipson & Smyth 2010), never zero.
    """
    found = differences(cells, name)
    if isinstance(found, Refusal):
        return found
    # Scaled by the largest, so that ties of sums can be told from rounding.
    sizes = np.sort(np.abs(found)) / np.abs(found).max()
    observed = abs(float(np.sum(np.sort(found)))) / float(np.abs(found).max())
    if cells.n <= EXACT_UP_TO:
        sums = _all_sums(sizes)
        p = float(np.mean(sums >= observed - 1e-9))
        method = f"exact, {2**cells.n} sign patterns"
    else:
        generator = np.random.default_rng(seed)
        sums = np.concatenate(
            [
                np.abs(generator.choice([-1.0, 1.0], size=(DRAWS // 9, cells.n)) @ sizes)
                for _ in range(9)
            ]
        )
        p = (float(np.sum(sums >= observed - 1e-9)) + 1) / (len(sums) + 1)
        method = f"{len(sums)} random sign patterns"
    mean = float(np.mean(np.sort(found)))
    return EffectResult(
        name=name,
        formula="mean of the participants' differences under random signs",
        role="sensitivity",
        statistic_name="mean",
        statistic=mean,
        df1=None,
        df2=None,
        p=p,
        estimate=mean,
        interval=None,
        effects=(),
        rows=2 * cells.n,
        participants=cells.participants,
        excluded=cells.excluded,
        method=method,
    )


def _all_sums(sizes: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the size of the sum under every pattern of signs, shape (2^n,)."""
    sums = np.zeros(1)
    for size in sizes:
        sums = np.concatenate([sums - size, sums + size])
    return np.abs(sums)
