"""The likelihood of ordinal answers with a random intercept, by adaptive Gauss-Hermite quadrature.

P(answer <= j | u) = logistic(alpha_j - x beta - sigma u), u standard normal by participant. The
nodes sit at the mode of each participant's integrand, scaled by its curvature (Pinheiro & Bates
1995, Journal of Computational and Graphical Statistics 4, 12-35), ten of them as with
`nAGQ = 10` of R's ordinal::clmm (Christensen 2018); with one node it is Laplace's approximation,
clmm's default. Many parameter vectors are evaluated at once, so that derivatives by differences
cost little.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
from scipy import optimize, special

Floats = npt.NDArray[np.float64]
NODES = 10
EDGE = 300.0
"""In place of infinity: logistic(300) is 1 in floating point, and exp(300) still a number."""
STEPS = 60


@dataclasses.dataclass(frozen=True, slots=True)
class Answers:
    """Rows of a cumulative-link model.

    Attributes:
        codes: category of each row, from 0, shape (n,).
        categories: their number, J.
        x: design without intercept, shape (n, p).
        members: 1 where a row is a participant's, shape (n, participants).
        nodes: of the quadrature for each participant; 1 is Laplace's approximation.
    """

    codes: npt.NDArray[np.int64]
    categories: int
    x: Floats
    members: Floats
    nodes: int = NODES

    @property
    def size(self) -> int:
        """Number of parameters: J - 1 thresholds, p coefficients, sigma."""
        return int(self.categories - 1 + self.x.shape[1] + 1)


@dataclasses.dataclass(frozen=True, slots=True)
class Maximum:
    """A maximum of the likelihood.

    Attributes:
        parameters: thresholds, coefficients, sigma.
        covariance: inverse of the negative Hessian, shape (size, size).
        log_likelihood: at the maximum.
        converged: whether the last step was negligible and the curvature is that of a maximum.
    """

    parameters: Floats
    covariance: Floats
    log_likelihood: float
    converged: bool


def log_likelihood(given: Answers, parameters: Floats, near: Floats | None = None) -> Floats:
    """Return the log likelihood of each row of parameters, shape (B, size) to (B,).

    Thresholds that do not rise give minus infinity. The search for participants' modes begins at
    ``near``, shape (participants,), if that is given: it changes the time taken, not the result.
    """
    cuts = given.categories - 1
    result = np.full(len(parameters), -np.inf)
    rising = np.all(np.diff(parameters[:, :cuts], axis=1) > 0, axis=1)
    fine = rising & np.isfinite(parameters).all(axis=1)
    if not fine.any():
        return result
    upper, lower, sigma = _bounds(given, parameters[fine])
    mode, curve = _modes(given, upper, lower, sigma, near)
    nodes, weights = np.polynomial.hermite.hermgauss(given.nodes)
    spread = np.sqrt(2 / curve)
    total = np.empty((given.nodes, *mode.shape))
    width = np.log(-np.expm1(-(upper - lower)))
    for place, (node, weight) in enumerate(zip(nodes, weights, strict=True)):
        u = mode + spread * node
        each = sigma * (u @ given.members.T)
        # log of logistic(upper) (1 - logistic(lower)), whose product with the width is their gap.
        up, down = np.exp(np.minimum(each - upper, EDGE)), np.exp(np.minimum(lower - each, EDGE))
        rows = width - np.log((1 + up) * (1 + down))
        total[place] = rows @ given.members - u**2 / 2 + node**2 + np.log(weight)
    inner = special.logsumexp(total, axis=0) + np.log(spread) - 0.5 * np.log(2 * np.pi)
    result[fine] = inner.sum(axis=1)
    return result


def _bounds(given: Answers, parameters: Floats) -> tuple[Floats, Floats, Floats]:
    """Return what bounds each answer, less its x beta, shapes (B, n), and sigma, (B, 1)."""
    cuts = given.categories - 1
    edge = np.full((len(parameters), 1), EDGE)
    bounds = np.hstack([-edge, parameters[:, :cuts], edge])
    shift = parameters[:, cuts:-1] @ given.x.T
    upper, lower = bounds[:, given.codes + 1] - shift, bounds[:, given.codes] - shift
    return upper, lower, parameters[:, -1:]


def _modes(
    given: Answers, upper: Floats, lower: Floats, sigma: Floats, near: Floats | None = None
) -> tuple[Floats, Floats]:
    """Find each participant's mode of the integrand and its curvature there, (B, participants).

    The integrand is log-concave: the sign of its slope says on which side the mode is. Newton's
    steps alone can go to and fro for ever where sigma is large, so that a step out of the bracket,
    or not half as long as the last, is replaced by halving the bracket.
    """
    widest = np.abs(sigma) * given.members.sum(axis=0) + 1  # an answer's slope is sigma at most
    low, high = -widest, widest
    mode, last = np.zeros_like(low), np.full_like(low, np.inf)
    if near is not None:
        mode = np.clip(mode + near, low, high)
    for _ in range(200):
        each = sigma * (mode @ given.members.T)
        above, below = special.expit(upper - each), special.expit(lower - each)
        slope = -(sigma * (1 - above - below)) @ given.members - mode
        curve = (sigma**2 * (above * (1 - above) + below * (1 - below))) @ given.members + 1
        low, high = np.where(slope > 0, mode, low), np.where(slope < 0, mode, high)
        step = slope / curve
        shorter = (np.abs(step) <= 0.5 * last) | (np.abs(step) < 1e-10)
        newton = shorter & (mode + step >= low) & (mode + step <= high)
        there = np.where(newton, mode + step, (low + high) / 2)
        last, mode = np.abs(there - mode), there
        if float(last.max()) < 1e-12:
            break
    return mode, curve


def maximise(given: Answers) -> Maximum:
    """Find the maximum by quasi-Newton steps, and by Newton's at the end.

    The likelihood is even in sigma: sigma = 0 is always level, and where it is no maximum the
    search is sent away from it. A search that ends nowhere, or there, is made again from a smaller
    spread.
    """
    shares = np.bincount(given.codes, minlength=given.categories).cumsum()[:-1] / len(given.codes)
    begin = np.concatenate([1.5 * special.logit(shares), np.zeros(given.x.shape[1])])
    found = []
    for spread in (1.5, 0.5):
        current, converged = _climb(given, _approach(given, np.append(begin, spread)))
        hessian = _derivatives(given, current)[1]
        if abs(current[-1]) < 0.05 and hessian[-1, -1] > 0:
            away = np.append(current[:-1], 2 * spread)
            current, converged = _climb(given, _approach(given, away))
        found.append((float(log_likelihood(given, current[None, :])[0]), current, converged))
        if converged and abs(current[-1]) >= 0.05:
            break
    best, current, converged = max(found, key=lambda one: one[0])
    current = current.copy()
    current[-1] = abs(current[-1])
    gradient, hessian = _derivatives(given, current)
    definite = bool(np.linalg.eigvalsh(hessian).max() < 0)
    steep = float(np.abs(gradient).max()) > 1e-3
    covariance: Floats = np.linalg.pinv(-hessian, hermitian=True).astype(np.float64)
    return Maximum(current, covariance, best, (converged or not steep) and definite)


def _approach(given: Answers, start: Floats) -> Floats:
    """Return a point near the maximum: gradients alone cost far less than curvatures."""

    def downhill(at: Floats) -> tuple[float, Floats]:
        moves = np.diag(_steps(given, at))
        points = np.array([at, *(at + m for m in moves), *(at - m for m in moves)])
        values = log_likelihood(given, points)
        if not np.isfinite(values).all():
            return 1e10, np.zeros_like(at)
        ahead, behind = values[1 : at.size + 1], values[at.size + 1 :]
        return -float(values[0]), -(ahead - behind) / (2 * np.diag(moves))

    found = optimize.minimize(
        downhill, start, jac=True, method="BFGS", options={"gtol": 1e-3, "maxiter": 60}
    )
    better = float(found.fun) < downhill(start)[0]
    return np.asarray(found.x if better else start, dtype=np.float64)


def _climb(given: Answers, start: Floats) -> tuple[Floats, bool]:
    """Return where the search from a start ends, and whether its last step was negligible."""
    current, best = start, float(log_likelihood(given, start[None, :])[0])
    for _ in range(STEPS):
        gradient, hessian = _derivatives(given, current)
        values, vectors = np.linalg.eigh(hessian)
        # Uphill in every direction, also where the surface is not yet concave.
        size = np.maximum(np.abs(values), 1e-6)
        move = vectors @ ((vectors.T @ gradient) / size)
        move *= min(1.0, 3.0 / float(np.abs(move).max() + 1e-300))
        ladder = current + move * 0.5 ** np.arange(20)[:, None]
        found = log_likelihood(given, ladder)
        place = int(np.argmax(found))
        small = float(np.abs(move).max()) < 1e-6 * (1 + float(np.abs(current).max()))
        if found[place] >= best:
            current, best = ladder[place], float(found[place])
        if small or not found[place] > best - 1e-12:
            return current, small
    return current, False


def _derivatives(given: Answers, at: Floats) -> tuple[Floats, Floats]:
    """Return gradient and Hessian by central differences, all points in one call."""
    size = given.size
    step = _steps(given, at)
    moves = np.diag(step)
    pairs = [(i, j) for i in range(size) for j in range(i)]
    points = [at, *(at + m for m in moves), *(at - m for m in moves)]
    for i, j in pairs:
        points += [at + a * moves[i] + b * moves[j] for a in (1, -1) for b in (1, -1)]
    upper, lower, sigma = _bounds(given, at[None, :])
    near = _modes(given, upper, lower, sigma)[0][0]
    values = log_likelihood(given, np.array(points), near)
    middle, ahead, behind = values[0], values[1 : size + 1], values[size + 1 : 2 * size + 1]
    gradient = (ahead - behind) / (2 * step)
    hessian = np.diag((ahead - 2 * middle + behind) / step**2)
    for place, (i, j) in enumerate(pairs):
        pp, pm, mp, mm = values[2 * size + 1 + 4 * place : 2 * size + 5 + 4 * place]
        hessian[i, j] = hessian[j, i] = (pp - pm - mp + mm) / (4 * step[i] * step[j])
    return gradient, hessian


def _steps(given: Answers, at: Floats) -> Floats:
    """Return steps of differences that keep the thresholds rising."""
    step: Floats = 2e-4 * np.maximum(1.0, np.abs(at))
    gaps = np.diff(at[: given.categories - 1])
    return np.minimum(step, float(gaps.min()) / 8) if gaps.size else step
