"""The navigation task on a grid: where each action leads from each node, and what it earns.

A node is a place, a heading and a health. Places and headings are carried through the task's
own dynamics, health by what hazards and packs add to it. What lands between nodes is shared
among those around it. The noise of a step is replaced by a few points with the same mean and
variance; that of the heading, which is small beside the headings' spacing, by that part of the
neighbouring headings that has the same variance.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.spatial import cKDTree

from study.tasks._navigation_dynamics import ACTIONS, Dynamics
from study.tasks._navigation_parameters import FULL_HEALTH, Parameters

Floats = npt.NDArray[np.float64]
States = npt.NDArray[np.float32]
Indices = npt.NDArray[np.intp]

_MIDDLE_HEALTH = 50.0
_ERRORS = np.sqrt(2.0) * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
"""Four equally likely errors in x and y, in standard deviations: unit variance, no covariance."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """Those outcomes of an action that change health by the same amount.

    Attributes:
        onward: sparse [k, k], from place and heading to place and heading, where no goal ends it.
        after: float64 [levels], the health after, points.
        carry: float64 [levels, levels], V at the health levels to V after; 0 where lost.
    """

    onward: sparse.csr_array
    after: Floats
    carry: Floats


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class ActionModel:
    """One action from every node.

    Attributes:
        branches: by change of health.
        rewards: float64 [k, levels], expected points.
        noisy_heading: whether the action has noise in the heading.
    """

    branches: tuple[Branch, ...]
    rewards: Floats
    noisy_heading: bool


class Grid:
    """The nodes, and how a state is shared among them.

    Attributes:
        places: float64 [p, 2], where a robot can be, metres.
        headings: float64 [h], radians in [-pi, pi).
        levels: float64 [levels], healths from 0 to full.

    Args:
        dynamics: the task's.
        cell: distance of places, metres; under the width of a wall to a robot, so that no cell
            reaches through one.
        headings: how many.
        levels: how many.
    """

    def __init__(self, dynamics: Dynamics, cell: float, headings: int, levels: int) -> None:
        layout = dynamics.terrain.layout
        if cell >= 2 * layout.robot_radius:
            raise ValueError(f"cells of {cell} m reach through walls")
        self.cell = cell
        self._columns, self._rows = round(layout.width / cell), round(layout.height / cell)
        x, y = np.meshgrid(
            (np.arange(self._columns) + 0.5) * cell, (np.arange(self._rows) + 0.5) * cell
        )
        legal = dynamics.terrain.is_legal(x, y)
        self._place_of = np.full(legal.shape, -1, np.intp)
        self._place_of[legal] = np.arange(legal.sum())
        self.places = np.stack([x[legal], y[legal]], axis=1)
        self.headings = -np.pi + 2 * np.pi * np.arange(headings) / headings
        self.levels = np.linspace(0.0, FULL_HEALTH, levels)
        self._nearest = cKDTree(self.places)

    @property
    def nodes(self) -> int:
        """Return k, the number of pairs of heading and place."""
        return len(self.headings) * len(self.places)

    def states(self, health: float) -> States:
        """Return the states float32 [k, 4] of all nodes, at one health."""
        count, places = len(self.headings), len(self.places)
        states = np.empty((count, places, 4))
        states[..., :2] = self.places
        states[..., 2] = self.headings[:, None]
        states[..., 3] = health
        # Rounding must not carry a heading out of its range.
        limit = np.nextafter(np.float32(np.pi), np.float32(0))
        flat = states.reshape(-1, 4).astype(np.float32)
        flat[:, 2] = np.clip(flat[:, 2], -limit, limit)
        return flat

    def share(self, states: States) -> tuple[Indices, Floats]:
        """Return the nodes [m, 8] around m states, and their shares [m, 8], adding up to 1."""
        at = states[:, :2].astype(np.float64) / self.cell - 0.5
        low = np.floor(at).astype(np.intp)
        part = at - low
        places, shares = [], []
        for right in (0, 1):
            for up in (0, 1):
                column, row = low[:, 0] + right, low[:, 1] + up
                inside = (column >= 0) & (column < self._columns) & (row >= 0) & (row < self._rows)
                place = self._place_of[
                    row.clip(0, self._rows - 1), column.clip(0, self._columns - 1)
                ]
                share = np.abs(1 - right - part[:, 0]) * np.abs(1 - up - part[:, 1])
                places.append(np.where(inside, place, -1))
                shares.append(np.where(inside & (place >= 0), share, 0.0))
        place, share = np.stack(places, axis=1), np.stack(shares, axis=1)
        # Where a wall leaves none of the four, the nearest place stands in.
        total = share.sum(axis=1)
        none = total < 1e-9
        if none.any():
            place[none, 0] = self._nearest.query(states[none, :2])[1]
            share[none] = (1.0, 0.0, 0.0, 0.0)
            total = np.where(none, 1.0, total)
        share /= total[:, None]
        place = np.maximum(place, 0)
        count = len(self.headings)
        turned = (states[:, 2].astype(np.float64) + np.pi) / (2 * np.pi) * count
        # A heading on a node belongs to it alone, whatever its last bit.
        near = np.rint(turned)
        turned = np.where(np.abs(turned - near) < 1e-5, near, turned)
        first = np.floor(turned).astype(np.intp)
        beyond = (turned - first)[:, None]
        nodes = [
            (heading % count)[:, None] * len(self.places) + place for heading in (first, first + 1)
        ]
        return np.concatenate(nodes, axis=1), np.concatenate(
            [share * (1 - beyond), share * beyond], axis=1
        )

    def level_shares(self, healths: Floats) -> Floats:
        """Return for m healths how each is shared among the levels, float64 [m, levels]."""
        at = np.clip(healths, 0.0, FULL_HEALTH) / FULL_HEALTH * (len(self.levels) - 1)
        shares: Floats = np.maximum(0.0, 1 - np.abs(at[:, None] - np.arange(len(self.levels))))
        return shares

    def smooth(self, values: Floats, noise: float) -> Floats:
        """Average values [k, levels] over headings with a deviation of ``noise`` radians."""
        part = min(0.5, (noise / (2 * np.pi / len(self.headings))) ** 2 / 2)
        by_heading = values.reshape(len(self.headings), len(self.places), -1)
        beside = np.roll(by_heading, 1, axis=0) + np.roll(by_heading, -1, axis=0)
        mixed: Floats = (1 - 2 * part) * by_heading + part * beside
        return mixed.reshape(values.shape)


class GridModel:
    """The task's transitions and rewards between nodes.

    Args:
        parameters: the task's.
        cell: distance of places, metres.
        headings: how many; where the turn divides the circle, a multiple of that number keeps
            turns on the grid.
        levels: how many healths; steps that divide damage and healing keep them on the grid.
    """

    def __init__(
        self, parameters: Parameters, cell: float = 0.25, headings: int = 24, levels: int = 21
    ) -> None:
        self.dynamics = Dynamics(parameters)
        self.noise = parameters.noise
        self.grid = Grid(self.dynamics, cell, headings, levels)
        if max(parameters.hazard_damage, parameters.pack_heal) >= _MIDDLE_HEALTH:
            raise ValueError("hazards and packs must change health by less than half of it")
        self.actions = tuple(self._action(action) for action in range(len(ACTIONS)))

    def ahead(self, values: Floats) -> Floats:
        """Return what is expected to follow each action, one timestep on, undiscounted.

        Args:
            values: V, float64 [k, levels].

        Returns:
            float64 [actions, k, levels], points.
        """
        smoothed = self.grid.smooth(values, self.noise)
        following = np.zeros((len(self.actions), *values.shape))
        for action, model in enumerate(self.actions):
            source = smoothed if model.noisy_heading else values
            for branch in model.branches:
                following[action] += branch.onward @ (source @ branch.carry.T)
        return following

    def under(self, actions: Indices) -> Callable[[Floats], Floats]:
        """Return what maps V to what is expected one timestep on under chosen actions.

        Args:
            actions: [k, levels], the action taken in each node.

        Returns:
            A function from V, float64 [k, levels], to the same shape.
        """
        total: sparse.csr_array | None = None
        count = len(self.grid.levels)
        for action, model in enumerate(self.actions):
            taken = sparse.diags_array((actions == action).ravel().astype(np.float64))
            for branch in model.branches:
                step = sparse.kron(branch.onward, sparse.csr_array(branch.carry), "csr")
                part = taken @ step
                if model.noisy_heading:
                    part = part @ self._smoothing()
                part.eliminate_zeros()
                total = part if total is None else total + part
        assert total is not None  # noqa: S101 - there are actions
        matrix = sparse.csr_array(total)
        return lambda values: (matrix @ values.ravel()).reshape(-1, count)

    def _smoothing(self) -> sparse.csr_array:
        """Return `Grid.smooth` as a matrix over nodes and levels."""
        headings, places = len(self.grid.headings), len(self.grid.places)
        part = min(0.5, (self.noise / (2 * np.pi / headings)) ** 2 / 2)
        rows = np.arange(headings)
        circle = sparse.csr_array(
            (
                np.concatenate([np.full(headings, 1 - 2 * part), np.full(2 * headings, part)]),
                (
                    np.tile(rows, 3),
                    np.concatenate([rows, (rows + 1) % headings, rows - 1]) % headings,
                ),
            ),
            shape=(headings, headings),
        )
        return sparse.kron(circle, sparse.eye_array(places * len(self.grid.levels)), "csr")

    def rewards(self) -> Floats:
        """Return the expected points of each action, float64 [actions, k, levels]."""
        return np.stack([model.rewards for model in self.actions])

    def _action(self, action: int) -> ActionModel:
        grid, points = self.grid, self.dynamics.parameters.rewards
        states = grid.states(_MIDDLE_HEALTH)
        count = len(states)
        actions = np.full(count, action)
        turned = self.dynamics.transition(states, actions, np.tile([0.0, 0.0, 1.0], (count, 1)))
        still = self.dynamics.transition(states, actions, np.zeros((count, 3)))
        noisy = bool((turned.states[:, 2] != still.states[:, 2]).any())
        moved = self.dynamics.transition(states, actions, np.tile([1.0, 1.0, 0.0], (count, 1)))
        errors = _ERRORS if (moved.states[:, :2] != still.states[:, :2]).any() else _ERRORS[:1] * 0

        pieces: dict[float, list[tuple[Indices, Indices, Floats]]] = {}
        rewards = np.zeros((count, len(grid.levels)))
        for error in errors:
            noise = np.tile([*error, 0.0], (count, 1))
            then = self.dynamics.transition(states, actions, noise)
            change = then.states[:, 3].astype(np.float64) - _MIDDLE_HEALTH
            base = then.rewards - points.health * change - points.goal * then.at_goal
            for delta in np.unique(change):
                rows = np.flatnonzero(change == delta)
                after = np.clip(grid.levels + delta, 0.0, FULL_HEALTH)
                lost = after <= 0
                earned = points.health * (after - grid.levels) + points.lost * lost
                goal = points.goal * then.at_goal[rows, None] * ~lost
                rewards[rows] += (base[rows, None] + earned + goal) / len(errors)
                onward = rows[~then.at_goal[rows]]
                nodes, shares = grid.share(then.states[onward])
                pieces.setdefault(float(delta), []).append((onward, nodes, shares / len(errors)))
        branches = tuple(self._branch(delta, pieces[delta], count) for delta in sorted(pieces))
        return ActionModel(branches, rewards, noisy)

    def _branch(
        self, delta: float, pieces: list[tuple[Indices, Indices, Floats]], count: int
    ) -> Branch:
        rows = np.concatenate([np.repeat(rows, nodes.shape[1]) for rows, nodes, _ in pieces])
        columns = np.concatenate([nodes.ravel() for _, nodes, _ in pieces])
        shares = np.concatenate([shares.ravel() for *_, shares in pieces])
        kept = shares > 0
        onward = sparse.csr_array((shares[kept], (rows[kept], columns[kept])), shape=(count, count))
        onward.sum_duplicates()
        after = np.clip(self.grid.levels + delta, 0.0, FULL_HEALTH)
        carry = self.grid.level_shares(after) * (after > 0)[:, None]
        return Branch(onward, after, carry)
