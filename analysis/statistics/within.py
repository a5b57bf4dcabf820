"""Repeated-measures ANOVA with any number of within-subject factors.

Each effect is tested on its orthonormal contrast scores, with its own error term; the sphericity
of their covariance is measured by Greenhouse and Geisser's epsilon and tested by Mauchly's W.
pingouin covers two factors and is silent about sphericity of an interaction of more than two
levels each; the tests compare with it where it answers, and with R.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy import linalg, stats

from analysis.statistics.cells import as_text, cell_means
from analysis.statistics.effect_sizes import cohens_dz, partial_eta_squared
from analysis.statistics.pairs import SMALLEST_N, not_finite
from analysis.statistics.result import Check, EffectResult, EffectSize, Interval, Outcome, Refusal
from study.errors import StudyError

Floats = npt.NDArray[np.float64]
JOINT = " / "


@dataclasses.dataclass(frozen=True, slots=True)
class Sphericity:
    """How far contrast scores are from equal variances without correlation.

    Attributes:
        greenhouse_geisser: epsilon, from 1 / d to 1.
        huynh_feldt: epsilon, at most 1.
        mauchly: Mauchly's test; None with one contrast, or with too few participants for it.
    """

    greenhouse_geisser: float
    huynh_feldt: float
    mauchly: Check | None


def sphericity(scores: Floats, cells: int) -> Sphericity:
    """Measure the sphericity of orthonormal contrast scores, shape (n, d).

    Args:
        scores: contrast scores.
        cells: of the whole design; R puts their number where Anderson's expansion has d (`3 * p` in
            `mauchly.test` of stats and car), which moves p in its fourth digit. As R prints it
            everywhere, so do we.

    Sources: Greenhouse & Geisser (1959), Psychometrika 24, 95-112; Huynh & Feldt (1976),
    Journal of Educational Statistics 1, 69-82; Mauchly (1940) with Anderson's expansion of p
    (2003, An Introduction to Multivariate Statistical Analysis, section 10.7), as in R.
    """
    n, d = scores.shape
    if d == 1:
        return Sphericity(1.0, 1.0, None)
    s = np.atleast_2d(np.cov(scores, rowvar=False))
    trace = float(np.trace(s))
    gg = trace**2 / (d * float(np.sum(s * s)))
    hf = min(1.0, (n * d * gg - 2) / (d * (n - 1 - d * gg))) if n - 1 > d * gg else 1.0
    free = n - 1
    if free < d:
        return Sphericity(gg, hf, None)
    sign, log_det = np.linalg.slogdet(s)
    if sign <= 0:
        return Sphericity(gg, hf, None)
    log_w = float(log_det) - d * float(np.log(trace / d))
    rho = 1 - (2 * d * d + d + 2) / (6 * d * free)
    w2 = 1.0 * (d + 2) * (d - 1) * (d - 2) * (2 * d**3 + 6 * d**2 + 3 * cells + 2)
    w2 /= 288 * (free * d * rho) ** 2
    z, f = -free * rho * log_w, d * (d + 1) / 2 - 1
    p = float(stats.chi2.sf(z, f))
    p = min(1.0, max(0.0, p + w2 * (float(stats.chi2.sf(z, f + 4)) - p)))
    note = "Degrees of freedom are corrected whatever it says; a small p says that it matters."
    check = Check("Mauchly's test of sphericity", "W", float(np.exp(log_w)), p, f, note)
    return Sphericity(gg, hf, check)


def contrasts(levels: int) -> Floats:
    """Return orthonormal contrasts among levels, shape (levels, levels - 1)."""
    return np.ascontiguousarray(linalg.helmert(levels).T)


def within_anova(
    frame: pd.DataFrame,
    value: str,
    factors: Mapping[str, Sequence[object]],
    name: str = "RM-ANOVA",
    *,
    participant: str = "participant",
) -> tuple[Outcome, ...] | Refusal:
    """Test every main effect and interaction on participants' cell means.

    Args:
        frame: a column of participants, one for each factor, and the value's.
        value: the column explained; several rows of a cell are averaged.
        factors: levels of each factor.
        name: what the tables call the tests, before the effect.
        participant: the column of participants.

    Returns:
        One result for each effect, main effects first, or a refusal: fewer than three
        participants with every cell, or a mean that is not finite. An effect whose contrasts do
        not vary between participants is refused in its place. p and df are corrected by
        Greenhouse and Geisser. An effect
        of factors of two levels has an estimate: the second level minus the first, averaged over
        the other factors, or the difference of such differences.

    Raises:
        StudyError: a column is missing or holds no numbers, or a factor has not two different
            levels.
    """
    names = list(factors)
    known = _levels(frame, factors)
    joint = [JOINT.join(cell) for cell in itertools.product(*known.values())]
    keyed = frame.assign(
        condition=functools.reduce(
            lambda left, right: left + JOINT + right, (as_text(frame[n]) for n in names)
        )
    )
    cells = cell_means(keyed, value, joint, participant=participant)
    n = cells.n
    if n < SMALLEST_N:
        reason = f"{n} participants have every cell; the test needs at least {SMALLEST_N}."
        return Refusal(name, reason, cells.excluded)
    refusal = not_finite(cells, name)
    if refusal is not None:
        return refusal
    sizes = [len(known[f]) for f in names]
    error_sum = 0.0
    tested: list[tuple[str, Floats, float, float]] = []
    for size in range(len(names) + 1):
        for chosen in itertools.combinations(range(len(names)), size):
            basis = functools.reduce(
                np.kron,
                [
                    contrasts(k) if place in chosen else np.full((k, 1), k**-0.5)
                    for place, k in enumerate(sizes)
                ],
            )
            scores = cells.means @ basis
            mean = scores.mean(axis=0)
            effect, error = n * float(mean @ mean), float(np.sum((scores - mean) ** 2))
            error_sum += error  # the empty choice is the variance between participants
            if chosen:
                tested.append((":".join(names[p] for p in chosen), scores, effect, error))
    scale = float(np.sum(cells.means**2))
    results: list[Outcome] = []
    for label, scores, effect, error in tested:
        if error <= 1e-22 * scale:
            reason = "The effect is the same for every participant, so that nothing tests it."
            results.append(Refusal(f"{name}: {label}", reason, cells.excluded))
            continue
        d = scores.shape[1]
        shape = sphericity(scores, cells.means.shape[1])
        f = (effect / d) / (error / (d * (n - 1)))
        epsilon = shape.greenhouse_geisser
        df1, df2 = d * epsilon, d * (n - 1) * epsilon
        note = f"Greenhouse-Geisser epsilon {epsilon:.3f}; without correction p = " if d > 1 else ""
        single = _single(cells.means, sizes, [names.index(f) for f in label.split(":")], f)
        results.append(
            EffectResult(
                name=f"{name}: {label}",
                formula=f"{value} ~ {' * '.join(names)}, error: participant x {label}",
                role="sensitivity",
                statistic_name="F",
                statistic=f,
                df1=df1,
                df2=df2,
                p=float(stats.f.sf(f, df1, df2)),
                estimate=single[0] if single else None,
                interval=single[1] if single else None,
                effects=(
                    *((single[2],) if single else ()),
                    partial_eta_squared(f, d, d * (n - 1)),
                    EffectSize("generalised eta squared", effect / (effect + error_sum)),
                ),
                rows=cells.means.size,
                participants=cells.participants,
                excluded=cells.excluded,
                note=note and f"{note}{float(stats.f.sf(f, d, d * (n - 1))):.3g}.",
                method="Greenhouse-Geisser" if d > 1 else "",
                checks=(shape.mauchly,) if shape.mauchly else (),
            )
        )
    return tuple(results)


def _levels(
    frame: pd.DataFrame, factors: Mapping[str, Sequence[object]]
) -> dict[str, tuple[str, ...]]:
    """Return the levels as text; see `within_anova` for what is refused."""
    if not factors:
        raise StudyError("there is no factor to test", "Give one, with its levels.")
    for factor, levels in factors.items():
        if factor not in frame.columns:
            shown = ", ".join(map(str, frame.columns))
            raise StudyError(f"the rows have no column {factor!r}; they have {shown}", "Name one.")
        if isinstance(levels, str) or len({str(level) for level in levels}) < max(2, len(levels)):
            raise StudyError(
                f"the factor {factor} needs two or more different levels; given: {levels!r}",
                "Give a list of its levels, the reference first.",
            )
    return {factor: tuple(str(level) for level in levels) for factor, levels in factors.items()}


def _single(
    means: Floats, sizes: Sequence[int], chosen: Sequence[int], f: float
) -> tuple[float, Interval, EffectSize] | None:
    """Return difference, interval and d_z of an effect of one degree of freedom; else None."""
    if any(sizes[place] != 2 for place in chosen):
        return None
    weights = functools.reduce(
        np.kron,
        [
            np.array([-1.0, 1.0]) if place in chosen else np.full(k, 1 / k)
            for place, k in enumerate(sizes)
        ],
    )
    n = len(means)
    estimate = float(np.mean(np.sort(means @ weights)))
    t = math.copysign(math.sqrt(f), estimate)
    error = float(np.std(np.sort(means @ weights), ddof=1)) / math.sqrt(n)
    reach = float(stats.t.ppf(0.975, n - 1)) * error
    return estimate, Interval(estimate - reach, estimate + reach), cohens_dz(t, n)
