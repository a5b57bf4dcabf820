"""Kenward and Roger's F test: small-sample covariance of the coefficients and its df.

Sources: Kenward & Roger (1997), Biometrics 53, 983-997, sections 2 and 3; Halekoh & Hoejsgaard
(2014), Journal of Statistical Software 59(9), whose choices for degenerate cases are kept.
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import numpy.typing as npt

from analysis.statistics.mixed.reml import Fit, right_multiply, trace_with

Floats = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class FTest:
    """A test of L beta = 0.

    Attributes:
        f: the statistic (scaled, where the method scales).
        df1: rank of L.
        df2: denominator degrees of freedom.
    """

    f: float
    df1: int
    df2: float


@dataclasses.dataclass(frozen=True, slots=True)
class KenwardRoger:
    """What the tests of one fit share.

    V is linear in its parameters: V itself (in place of the identity, whose span with the
    others is the same, and to whose choice the method is invariant) and Z A Z' for each entry
    of each covariance matrix, variances at zero included.

    Attributes:
        beta: coefficients, units of y by units of x, shape (p,).
        phi: their covariance as if V were known, shape (p, p).
        adjusted: the same, corrected for estimating V, shape (p, p).
        p_matrices: P_i = -X'V^-1 G_i V^-1 X of each parameter, list of (p, p).
        w: asymptotic covariance of the parameters, shape (r, r).
    """

    beta: Floats
    phi: Floats
    adjusted: Floats
    p_matrices: list[Floats]
    w: Floats


def kenward_roger(fit: Fit) -> KenwardRoger:
    """Compute the adjusted covariance and what the degrees of freedom need."""
    given, point, s2 = fit.moments, fit.point, fit.s**2
    phi, zpz, zhx = s2 * point.phi, point.zpz / s2, point.zhx / s2
    entries = []
    for b, block in enumerate(fit.blocks):
        for i, j in itertools.combinations_with_replacement(range(block.size), 2):
            small = np.zeros((block.size, block.size))
            small[i, j] = small[j, i] = 1.0
            entries.append((b, small))
    count = len(entries) + 1
    information = np.empty((count, count))  # tr(P G_i P G_j): twice the expected information
    information[0, 0] = given.n - given.p
    p_matrices = [-np.linalg.inv(phi)]
    for place, (b, small) in enumerate(entries, start=1):
        block = fit.blocks[b]
        information[0, place] = information[place, 0] = trace_with(zpz, block, small)
        p_matrices.append(-right_multiply(zhx.T, block, small) @ zhx[block.columns])
        for other, (c, small_c) in enumerate(entries[:place], start=1):
            second = fit.blocks[c]
            left = right_multiply(zpz[second.columns], block, small)
            right = right_multiply(zpz[block.columns], second, small_c)
            information[place, other] = information[other, place] = np.sum(left * right.T)
    w = 2 * _inverse(information)
    total = np.zeros_like(phi)
    for (i, (b, small)), (j, (c, small_c)) in itertools.product(enumerate(entries, 1), repeat=2):
        block, second = fit.blocks[b], fit.blocks[c]
        left = right_multiply(zhx.T, block, small)
        right = right_multiply(zhx.T, second, small_c)
        total += w[i, j] * left @ zpz[block.columns, second.columns] @ right.T
    adjusted = phi + 2 * phi @ total @ phi
    # Back from the orthonormal basis and the scaled residuals.
    back = np.linalg.inv(given.r)
    beta = back @ (given.start + given.scale * point.beta)
    unit = given.scale**2
    forward = given.r.T
    return KenwardRoger(
        beta=beta,
        phi=unit * back @ phi @ back.T,
        adjusted=unit * back @ ((adjusted + adjusted.T) / 2) @ back.T,
        p_matrices=[forward @ matrix @ given.r / unit for matrix in p_matrices],
        w=w,
    )


def f_test(parts: KenwardRoger, contrasts: Floats) -> FTest:
    """Test L beta = 0.

    Args:
        parts: of the fit.
        contrasts: L of full row rank, shape (df1, p).
    """
    q = contrasts.shape[0]
    theta = contrasts.T @ np.linalg.solve(contrasts @ parts.phi @ contrasts.T, contrasts)
    products = [theta @ parts.phi @ matrix @ parts.phi for matrix in parts.p_matrices]
    traces = np.array([np.trace(u) for u in products])
    crossed = np.array([[np.sum(u * v.T) for v in products] for u in products])
    a1 = float(np.sum(parts.w * np.outer(traces, traces)))
    a2 = float(np.sum(parts.w * crossed))
    b = (a1 + 6 * a2) / (2 * q)
    g = ((q + 1) * a1 - (q + 4) * a2) / ((q + 2) * a2)
    below = 3 * q + 2 * (1 - g)
    c1, c2, c3 = g / below, (q - g) / below, (q + 2 - g) / below
    v0, v1, v2 = 1 + c1 * b, 1 - c2 * b, 1 - c3 * b
    v0 = 0.0 if abs(v0) < 1e-10 else v0
    mean_part = 1 - a2 / q
    both_zero = abs(mean_part) < 1e-14 and abs(v1) < 1e-14
    # With hardly any participants a divisor can be zero: as in R the quotient is then not finite,
    # and whoever asked sees that in the result.
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.float64(1.0) if both_zero else np.float64(mean_part) / v1
        rho = ratio**2 * v0 / v2 / q
        df2 = float(4 + (q + 2) / (q * rho - 1))
        near_two = abs(df2 - 2) < 1e-2
        scaling = 1.0 if near_two else float(df2 * mean_part / np.float64(df2 - 2))
    distance = contrasts @ parts.beta
    wald = float(distance @ np.linalg.solve(contrasts @ parts.adjusted @ contrasts.T, distance))
    return FTest(scaling * wald / q, q, df2)


def _inverse(information: Floats) -> Floats:
    """Invert, in the sense of Moore and Penrose where parameters cannot be told apart."""
    scale = np.sqrt(np.diag(information))
    scale[scale == 0] = 1.0
    balanced = information / np.outer(scale, scale)
    inverse = np.linalg.pinv(balanced, rcond=1e-11, hermitian=True) / np.outer(scale, scale)
    return np.asarray(inverse, dtype=np.float64)
