"""The report's primary test on made-up studies: many at once where it is that of the means.

`analyse_many` gives what `analysis.robustness.primary_test` gives for each study; a test holds that
result by result. Where trials are missing that is a mixed model, fitted study by study.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
from scipy import stats

from analysis.planning.made_up import MadeUp, level_names
from analysis.robustness import primary_test
from analysis.statistics.cells import cell_means
from analysis.statistics.pairs import SMALLEST_N
from analysis.statistics.result import EffectResult

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, slots=True)
class Tested:
    """The primary tests of some studies.

    Attributes:
        p: of each, shape (studies,); NaN where the test refuses.
        estimates: last condition less the reference; NaN without an estimate.
        by_model: whether trials were missing, so that the mixed model was tried.
    """

    p: Floats
    estimates: Floats
    by_model: Flags


def analyse_one(studies: MadeUp, study: int) -> tuple[float, float]:
    """Return p and estimate of one study's primary test by the analysis itself; NaN for none."""
    frame = studies.frame(study)
    levels = level_names(studies.places.shape[1])
    outcome = primary_test(frame, cell_means(frame, "team_reward", levels, "complete trials"))
    if not isinstance(outcome, EffectResult):
        return np.nan, np.nan
    return outcome.p, np.nan if outcome.estimate is None else outcome.estimate


def analyse_many(studies: MadeUp) -> Tested:
    """Test each study."""
    counts = studies.there.sum(axis=3)  # (studies, participants, conditions)
    kept = counts.sum(axis=2) > 0
    fewest = np.where(kept[:, :, None], counts, np.iinfo(counts.dtype).max).min(axis=(1, 2))
    by_model = kept.any(axis=1) & (counts.max(axis=(1, 2)) > fewest)
    p, estimates = _tests_of_means(studies, counts, kept & ~by_model[:, None])
    for study in np.flatnonzero(by_model):
        p[study], estimates[study] = analyse_one(studies, int(study))
    return Tested(p, estimates, by_model)


def _tests_of_means(
    studies: MadeUp, counts: npt.NDArray[np.int64], kept: Flags
) -> tuple[Floats, Floats]:
    """Return p and estimate of each study from its kept participants; NaN where it refuses."""
    sums = np.where(studies.there, studies.rewards, 0.0).sum(axis=3)
    means = np.where(kept[:, :, None], sums / np.maximum(counts, 1), np.nan)
    n = kept.sum(axis=1)
    enough = n >= SMALLEST_N
    used = means[enough]
    p, estimates = np.full(len(n), np.nan), np.full(len(n), np.nan)
    if not used.size:
        return p, estimates
    found = _paired if means.shape[2] == 2 else _several
    p[enough], estimates[enough] = found(used, n[enough].astype(np.float64))
    flat = _flat(used)
    p[np.flatnonzero(enough)[flat]] = np.nan
    estimates[np.flatnonzero(enough)[flat]] = np.nan
    return p, estimates


def _flat(means: Floats) -> Flags:
    """Return whether some difference from the reference does not vary, as `rm_anova` has it."""
    differences = means[:, :, 1:] - means[:, :, :1]
    spread = np.nanmax(differences, axis=1) - np.nanmin(differences, axis=1)
    scale = np.maximum(np.nanmax(np.abs(means), axis=(1, 2)), 1.0)
    return np.asarray((spread <= 1e-12 * scale[:, None]).any(axis=1))


def _paired(means: Floats, n: Floats) -> tuple[Floats, Floats]:
    differences = means[:, :, 1] - means[:, :, 0]
    estimates = np.nanmean(differences, axis=1)
    errors = np.nanstd(differences, axis=1, ddof=1) / np.sqrt(n)
    with np.errstate(divide="ignore", invalid="ignore"):
        p = 2 * np.asarray(stats.t.sf(np.abs(estimates / errors), n - 1))
    return p, estimates


def _several(means: Floats, n: Floats) -> tuple[Floats, Floats]:
    """Return p of the F test, corrected by Greenhouse and Geisser's epsilon; no one estimate."""
    c = means.shape[2]
    by_condition = np.nanmean(means, axis=1, keepdims=True)
    centred = means - by_condition
    within = np.where(np.isnan(centred), 0.0, centred)
    covariance = np.einsum("spi,spj->sij", within, within) / (n - 1)[:, None, None]
    # Rows and columns centred: what is left is the scatter of the contrasts.
    rows = covariance.mean(axis=2, keepdims=True)
    left = covariance - rows - rows.transpose(0, 2, 1) + covariance.mean(axis=(1, 2), keepdims=True)
    trace = np.trace(left, axis1=1, axis2=2)
    grand = by_condition.mean(axis=2, keepdims=True)
    between = n * ((by_condition - grand) ** 2).sum(axis=(1, 2)) / (c - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        epsilon = np.minimum(trace**2 / ((c - 1) * (left**2).sum(axis=(1, 2))), 1.0)
        f = between / (trace / (c - 1))
        p = stats.f.sf(f, (c - 1) * epsilon, (c - 1) * (n - 1) * epsilon)
    return p, np.full(len(n), np.nan)
