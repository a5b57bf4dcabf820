"""Restricted maximum likelihood for y = X beta + Z b + e by dense algebra in NumPy.

The covariance is V = s^2 H with H = I + Z Lambda Lambda' Z'; each block of Lambda repeats one
lower-triangular matrix, whose entries are theta, as in lme4 (Bates, Maechler, Bolker & Walker
2015, Journal of Statistical Software 67(1), section 3). Everything is computed in the q
dimensions of the random effects, whatever the number of rows.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt
from scipy import linalg, optimize

from analysis.statistics.mixed.design import Block, Design

Floats = npt.NDArray[np.float64]
SINGULAR = 1e-4  # lme4's isSingular: the smallest diagonal entry of theta that counts as nonzero


@dataclasses.dataclass(frozen=True, slots=True)
class Moments:
    """Cross-products of a design whose x is orthonormal and whose y is scaled residuals.

    Attributes:
        zz, zx, zy, yy: Z'Z (q, q), Z'Q (q, p), Z'r (q,) and r'r, where X = Q R and r are the
            residuals of least squares divided by their scale.
        r: R, shape (p, p).
        start: coefficients of least squares in the basis of Q, in units of y.
        scale: of the residuals, in units of y.
        n: number of rows.
    """

    zz: Floats
    zx: Floats
    zy: Floats
    yy: float
    r: Floats
    start: Floats
    scale: float
    n: int

    @property
    def p(self) -> int:
        """Number of fixed coefficients."""
        return int(self.r.shape[0])


@dataclasses.dataclass(frozen=True, slots=True)
class Point:
    """All that theta determines, with s = 1: criterion, its gradient, and projections.

    Attributes:
        criterion: profiled REML criterion (up to the constants of scaling).
        gradient: by theta, shape (m,).
        rss: r'P r.
        beta: coefficients in the basis of Q, as a deviation from least squares, scaled.
        phi: (Q'H^-1 Q)^-1, shape (p, p).
        zhz: Z'H^-1 Z, shape (q, q).
        zhx: Z'H^-1 Q, shape (q, p).
        zpz: Z'P Z, shape (q, q).
        u: Z'P r, shape (q,).
    """

    criterion: float
    gradient: Floats
    rss: float
    beta: Floats
    phi: Floats
    zhz: Floats
    zhx: Floats
    zpz: Floats
    u: Floats


@dataclasses.dataclass(frozen=True, slots=True)
class Fit:
    """A model at the maximum of its restricted likelihood.

    Attributes:
        moments: what it rests on.
        blocks: blocks of random effects.
        theta: relative Cholesky factors, by block, column by column.
        point: everything at theta.
        s: residual standard deviation in scaled units.
        criterion: -2 log restricted likelihood, in the units of y, as lme4 prints it.
    """

    moments: Moments
    blocks: tuple[Block, ...]
    theta: Floats
    point: Point
    s: float
    criterion: float

    @property
    def sigma(self) -> float:
        """Residual standard deviation in units of y."""
        return self.s * self.moments.scale

    @property
    def singular(self) -> bool:
        """Whether a variance, or a direction of a covariance matrix, is estimated as zero."""
        return any(bool(np.any(np.diag(f) < SINGULAR)) for f in factors(self.theta, self.blocks))

    def covariances(self) -> list[Floats]:
        """Return each block's covariance matrix of random effects, shape (k, k), units of y."""
        return [self.sigma**2 * f @ f.T for f in factors(self.theta, self.blocks)]


def theta_places(blocks: tuple[Block, ...]) -> list[tuple[int, int, int]]:
    """Return (block, row, column) of every entry of theta, in lme4's order."""
    return [
        (b, i, j)
        for b, block in enumerate(blocks)
        for j in range(block.size)
        for i in range(j, block.size)
    ]


def factors(theta: Floats, blocks: tuple[Block, ...]) -> list[Floats]:
    """Return the lower-triangular factor of each block, shape (k, k)."""
    found = [np.zeros((block.size, block.size)) for block in blocks]
    for value, (b, i, j) in zip(theta, theta_places(blocks), strict=True):
        found[b][i, j] = value
    return found


def right_multiply(matrix: Floats, block: Block, small: Floats) -> Floats:
    """Return M (I_g kron small) for the block's columns of M: shape (rows, g * k)."""
    part = matrix[:, block.columns].reshape(matrix.shape[0], block.groups, block.size)
    return np.asarray((part @ small).reshape(matrix.shape[0], -1))


def moments(design: Design) -> Moments | None:
    """Reduce a design to cross-products; None where least squares leave no scatter."""
    q, r = np.linalg.qr(design.x)
    start = q.T @ design.y
    rest = design.y - q @ start
    rest = rest - q @ (q.T @ rest)
    n, p = design.x.shape
    scale = float(np.sqrt(rest @ rest / (n - p)))
    if not scale > 1e-10 * max(float(np.abs(design.y).max()), 1e-300):
        return None
    rest = rest / scale
    z = design.z
    return Moments(z.T @ z, z.T @ q, z.T @ rest, float(rest @ rest), r, start, scale, n)


def evaluate(theta: Floats, given: Moments, blocks: tuple[Block, ...]) -> Point:
    """Compute the profiled criterion, its gradient and the projections at theta.

    With G = Lambda Lambda', Woodbury's identity gives Z'H^-1 = (I + Z'Z G)^-1 Z'. Raises
    numpy.linalg.LinAlgError where the matrices are not positive definite in floating point.
    """
    n, p, q = given.n, given.p, given.zz.shape[0]
    zw = np.column_stack([given.zx, given.zy])
    small = factors(theta, blocks)
    gamma = np.zeros((q, q))
    for block, factor in zip(blocks, small, strict=True):
        gamma[block.columns, block.columns] = np.kron(np.eye(block.groups), factor @ factor.T)
    lu, pivots = linalg.lu_factor(np.eye(q) + given.zz @ gamma, check_finite=False)
    solved = linalg.lu_solve((lu, pivots), np.column_stack([given.zz, zw]), check_finite=False)
    zhz, zhx, zhy = solved[:, :q], solved[:, q : q + p], solved[:, -1]
    zhz = (zhz + zhz.T) / 2
    xhx = np.eye(p) - given.zx.T @ gamma @ zhx
    xhx = (xhx + xhx.T) / 2
    root = np.linalg.cholesky(xhx)
    phi = linalg.cho_solve((root, True), np.eye(p))
    xhy = -given.zx.T @ (gamma @ zhy)
    beta = phi @ xhy
    rss = given.yy - float(given.zy @ gamma @ zhy) - float(xhy @ beta)
    if not rss > 0:
        raise np.linalg.LinAlgError("the residual sum of squares is not positive")
    u = zhy - zhx @ beta
    zpz = zhz - zhx @ phi @ zhx.T
    log_h = float(np.log(np.abs(np.diag(lu))).sum())
    log_x = 2 * float(np.log(np.diag(root)).sum())
    criterion = log_h + log_x + (n - p) * (1 + math.log(2 * math.pi * rss / (n - p)))
    gradient = np.array(
        [
            trace_with(zpz, blocks[b], d) - (n - p) * quadratic(u, u, blocks[b], d) / rss
            for b, d in derivatives(theta, blocks)
        ]
    )
    return Point(criterion, gradient, rss, beta, phi, zhz, zhx, zpz, u)


def derivatives(theta: Floats, blocks: tuple[Block, ...]) -> list[tuple[int, Floats]]:
    """Return, for each entry of theta, its block and the derivative of factor @ factor.T."""
    small = factors(theta, blocks)
    found = []
    for b, i, j in theta_places(blocks):
        unit = np.zeros_like(small[b])
        unit[i, j] = 1.0
        found.append((b, unit @ small[b].T + small[b] @ unit.T))
    return found


def trace_with(matrix: Floats, block: Block, small: Floats) -> float:
    """Return tr(M (I kron small)) over the block's part of M."""
    part = matrix[block.columns, block.columns]
    part = part.reshape(block.groups, block.size, block.groups, block.size)
    return float(np.einsum("gigj,ji->", part, small))


def quadratic(left: Floats, right: Floats, block: Block, small: Floats) -> float:
    """Return left' (I kron small) right over the block's part."""
    shape = (block.groups, block.size)
    return float(
        np.sum((left[block.columns].reshape(shape) @ small) * right[block.columns].reshape(shape))
    )


def fit(given: Moments, blocks: tuple[Block, ...]) -> Fit:
    """Maximise the restricted likelihood.

    The criterion is even in each column of a factor, so that the search needs no bounds: signs
    are set afterwards, and a diagonal entry of zero is the boundary. Two starts guard against
    a stop beside it.
    """
    places = theta_places(blocks)
    on_diagonal = np.array([i == j for _, i, j in places], dtype=bool)
    starts = [np.where(on_diagonal, size, other) for size, other in ((1.0, 0.0), (0.15, 0.05))]
    best = min((_search(start, given, blocks) for start in starts), key=lambda found: found[0])[1]
    best = _polish(_signed(best, blocks), given, blocks)
    best = _settle_on_boundary(best, on_diagonal, given, blocks)
    point = evaluate(best, given, blocks)
    log_r = 2 * float(np.log(np.abs(np.diag(given.r))).sum())
    criterion = point.criterion + log_r + 2 * (given.n - given.p) * math.log(given.scale)
    s = math.sqrt(point.rss / (given.n - given.p))
    return Fit(given, blocks, best, point, s, criterion)


def _search(start: Floats, given: Moments, blocks: tuple[Block, ...]) -> tuple[float, Floats]:
    def value(theta: Floats) -> tuple[float, Floats]:
        try:
            point = evaluate(theta, given, blocks)
        except np.linalg.LinAlgError:
            return 1e15, np.zeros_like(theta)
        return point.criterion, point.gradient

    if not start.size:
        return 0.0, start
    found = optimize.minimize(value, start, jac=True, method="BFGS", options={"gtol": 1e-7})
    return float(found.fun), np.asarray(found.x, dtype=np.float64)


def _signed(theta: Floats, blocks: tuple[Block, ...]) -> Floats:
    """Make the diagonals of the factors nonnegative; the covariances stay the same."""
    small = [f * np.where(np.diag(f) < 0, -1.0, 1.0)[None, :] for f in factors(theta, blocks)]
    return np.array([small[b][i, j] for b, i, j in theta_places(blocks)])


def _polish(theta: Floats, given: Moments, blocks: tuple[Block, ...]) -> Floats:
    """Take Newton steps with differences of the exact gradient, while they improve."""
    current = evaluate(theta, given, blocks)
    for _ in range(8):
        if np.abs(current.gradient).max(initial=0.0) < 1e-10:
            break
        hessian = np.empty((theta.size, theta.size))
        for place in range(theta.size):
            step = np.zeros_like(theta)
            step[place] = 1e-5 * max(1.0, abs(theta[place]))
            ahead, behind = (evaluate(theta + sign * step, given, blocks) for sign in (1, -1))
            hessian[place] = (ahead.gradient - behind.gradient) / (2 * step[place])
        move = np.linalg.lstsq((hessian + hessian.T) / 2, -current.gradient, rcond=1e-9)[0]
        try:
            candidate = evaluate(theta + move, given, blocks)
        except np.linalg.LinAlgError:
            break
        smaller = np.abs(candidate.gradient).max() < np.abs(current.gradient).max()
        if not smaller or candidate.criterion > current.criterion + 1e-9:
            break
        theta, current = theta + move, candidate
    return _signed(theta, blocks)


def _settle_on_boundary(
    theta: Floats, on_diagonal: npt.NDArray[np.bool_], given: Moments, blocks: tuple[Block, ...]
) -> Floats:
    """Set to zero what is zero but for rounding."""
    settled = np.where(on_diagonal & (theta < SINGULAR), 0.0, theta)
    if np.array_equal(settled, theta):
        return theta
    before = evaluate(theta, given, blocks).criterion
    return settled if evaluate(settled, given, blocks).criterion <= before + 1e-7 else theta
