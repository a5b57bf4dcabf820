"""Satterthwaite's degrees of freedom for one contrast, Fai and Cornelius's for several.

Sources: Satterthwaite (1946), Biometrics Bulletin 2, 110-114; Fai & Cornelius (1996), Journal
of Statistical Computation and Simulation 54, 363-378; Kuznetsova, Brockhoff & Christensen
(2017), Journal of Statistical Software 82(13), whose parameters (theta, sigma) are used. They
matter: where a variance is estimated as zero its theta has no effect on the covariance of the
coefficients, so that the df are those of a model without it. Prefer Kenward-Roger there.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from analysis.statistics.mixed.kenward_roger import FTest
from analysis.statistics.mixed.reml import (
    Fit,
    derivatives,
    quadratic,
    right_multiply,
    theta_places,
    trace_with,
)

Floats = npt.NDArray[np.float64]
TOLERANCE = 1e-8  # eigenvalues of the information at most this large carry no information


@dataclasses.dataclass(frozen=True, slots=True)
class Satterthwaite:
    """What the tests of one fit share.

    Attributes:
        beta: coefficients, shape (p,).
        phi: their covariance, shape (p, p).
        slopes: derivatives of phi by theta and sigma, list of (p, p).
        variances: covariance of (theta, sigma), shape (m + 1, m + 1).
    """

    beta: Floats
    phi: Floats
    slopes: list[Floats]
    variances: Floats


def satterthwaite(fit: Fit) -> Satterthwaite:
    """Compute the exact Hessian of the restricted likelihood and the derivatives of phi."""
    given, point, s = fit.moments, fit.point, fit.s
    s2 = s**2
    zpz, u, phi = point.zpz / s2, point.u / s2, s2 * point.phi
    zhx = point.zhx / s2
    first = derivatives(fit.theta, fit.blocks)
    places = theta_places(fit.blocks)
    m = len(first)
    hessian = np.zeros((m + 1, m + 1))
    slopes = []
    for i, (b, small) in enumerate(first):
        block = fit.blocks[b]
        # V_i = s^2 Z (I kron small) Z'.
        slopes.append(s2 * phi @ right_multiply(zhx.T, block, small) @ zhx[block.columns] @ phi)
        hessian[i, m] = hessian[m, i] = 2 * s * quadratic(u, u, block, small)
        for j, (c, small_c) in enumerate(first):
            other = fit.blocks[c]
            left = right_multiply(zpz[other.columns], block, small)
            right = right_multiply(zpz[block.columns], other, small_c)
            trace = float(np.sum(left * right.T))
            moved = right_multiply(u[None, :], block, small)[0]
            moved_c = right_multiply(u[None, :], other, small_c)[0]
            cross = float(moved @ zpz[block.columns, other.columns] @ moved_c)
            hessian[i, j] = s2**2 * (2 * cross - trace)
            (_, row, column), (_, row_c, column_c) = places[i], places[j]
            if b == c and column == column_c:
                second = np.zeros_like(small)
                second[row, row_c] += 1.0
                second[row_c, row] += 1.0
                hessian[i, j] += s2 * (
                    trace_with(zpz, block, second) - quadratic(u, u, block, second)
                )
    free = given.n - given.p
    hessian[m, m] = 2 * (3 * point.rss / s2 - free) / s2
    slopes.append(2 / s * phi)
    values, vectors = np.linalg.eigh((hessian + hessian.T) / 2)
    kept = values > TOLERANCE
    variances = 2 * (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    back, unit = np.linalg.inv(given.r), given.scale**2
    return Satterthwaite(
        beta=back @ (given.start + given.scale * point.beta),
        phi=unit * back @ phi @ back.T,
        slopes=[unit * back @ slope @ back.T for slope in slopes],
        variances=variances,
    )


def f_test(parts: Satterthwaite, contrasts: Floats) -> FTest:
    """Test L beta = 0.

    Args:
        parts: of the fit.
        contrasts: L of full row rank, shape (df1, p). Where df1 > 1 and the design is not
            balanced, df2 depends on the basis of L's rows, as in lmerTest.
    """
    values, vectors = np.linalg.eigh(contrasts @ parts.phi @ contrasts.T)
    rotated = vectors.T @ contrasts
    f = float(np.mean((rotated @ parts.beta) ** 2 / values))
    slopes = np.array([[row @ slope @ row for slope in parts.slopes] for row in rotated])
    spread = np.einsum("qi,ij,qj->q", slopes, parts.variances, slopes)
    each = 2 * values**2 / spread
    return FTest(f, len(each), _combined(each))


def _combined(each: Floats) -> float:
    """Return the df of a mean of squared t variables from the df of each."""
    if len(each) == 1 or np.all(np.abs(np.diff(each)) < TOLERANCE):
        return float(each.mean())
    if np.any(each <= 2):
        return 2.0
    expected = float(np.sum(each / (each - 2)))
    return 2 * expected / (expected - len(each))
