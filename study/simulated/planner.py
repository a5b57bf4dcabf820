"""The way to the goal on a grid, read off the map as it is drawn."""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from study.events.scene import DiscMark, RectangleMark, Scene

CELL_M = 0.25
_STEPS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))

Grid = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


class Route:
    """Cost-to-go to the nearest of some discs, and where to aim from each cell.

    Attributes:
        cost: metres for each cell, row by row from the bottom; hazard and closeness to
            obstacles count extra; 0 within a disc. Blocked cells have the cost of the
            nearest free one.
        aim_x, aim_y: the point a look-ahead further along the way, metres.
        longest: the largest cost, metres.
    """

    __slots__ = ("aim_x", "aim_y", "cost", "longest")

    def __init__(self, cost: Grid, aim_x: Grid, aim_y: Grid) -> None:
        # Lists of floats: single cells are read each timestep, where NumPy scalars are slow.
        self.cost: list[float] = cost.tolist()
        self.aim_x: list[float] = aim_x.tolist()
        self.aim_y: list[float] = aim_y.tolist()
        self.longest = max(self.cost)


class Plan:
    """All that an operator knows of a map.

    Attributes:
        columns, rows: size of the grid of cells of side `CELL_M`.
        goal: the way to the goal.
        packs: the way to the nearest health pack, or None if there is none.
    """

    def __init__(
        self,
        scene: Scene,
        hazard_cost: float,
        clearance: float,
        look_ahead: float,
    ) -> None:
        self.columns = max(1, math.ceil(scene.width / CELL_M))
        self.rows = max(1, math.ceil(scene.height / CELL_M))
        xs = (np.arange(self.columns) + 0.5) * CELL_M
        ys = (np.arange(self.rows) + 0.5) * CELL_M
        self._x, self._y = (grid.ravel() for grid in np.meshgrid(xs, ys))
        walls = [mark for mark in scene.rectangles if mark.role == "wall"]
        if scene.plate is not None:
            walls.append(RectangleMark("wall", *scene.plate))
        hazards = [mark for mark in scene.rectangles if mark.role == "hazard"]
        to_wall = np.minimum(self._distance(walls), self._distance_to_bounds(scene))
        to_hazard = self._distance(hazards)
        free = to_wall >= scene.robot_radius
        if not free.any():
            free[:] = True
        margin: Grid = np.minimum(to_wall - scene.robot_radius, to_hazard)
        weight: Grid = np.where(to_hazard <= 0.0, 1.0 + hazard_cost, 1.0)
        if clearance > 0.01:
            weight += np.clip(1.0 - margin / clearance, 0.0, 1.0)
        graph = self._graph(free, weight)
        self._hazard: list[bool] = (to_hazard <= 0.0).tolist()
        self._blocked: list[bool] = (~free).tolist()
        goals = [mark for mark in scene.discs if mark.role == "goal"]
        packs = [mark for mark in scene.discs if mark.role == "health_pack"]
        # A map that shows no goal has its middle for one, so that a robot is driven at all.
        middle = DiscMark("goal", scene.width / 2, scene.height / 2, CELL_M)
        self.goal = self._route(graph, free, goals or [middle], look_ahead)
        self.packs = self._route(graph, free, packs, look_ahead) if packs else None

    @property
    def longest(self) -> float:
        """The farthest that a robot can have to go, metres."""
        longest: float = self.goal.longest
        return longest

    @property
    def period(self) -> float:
        """0: the way leads to a goal."""
        return 0.0

    def to_go(self, x: float, y: float, heading: float) -> tuple[float, float]:
        """Return the way left from (x, y), metres, and the turn to face it, radians, no sign."""
        cell = self.cell(x, y)
        route = self.goal
        if route.cost[cell] <= 0.0:
            return 0.0, 0.0
        aim = math.atan2(route.aim_y[cell] - y, route.aim_x[cell] - x)
        return route.cost[cell], abs(difference(aim, heading))

    def cell(self, x: float, y: float) -> int:
        """Return the number of the cell that holds (x, y) metres; the nearest if outside."""
        column = min(max(int(x / CELL_M), 0), self.columns - 1)
        row = min(max(int(y / CELL_M), 0), self.rows - 1)
        return row * self.columns + column

    def in_hazard(self, x: float, y: float) -> bool:
        """Return whether (x, y) metres lies in a hazard, to the precision of a cell."""
        return self._hazard[self.cell(x, y)]

    def hazard_ahead(self, x: float, y: float, heading: float, reach: float) -> bool:
        """Return whether a hazard lies straight ahead within ``reach`` metres, before a wall."""
        step_x, step_y = CELL_M * math.cos(heading), CELL_M * math.sin(heading)
        for _ in range(int(reach / CELL_M)):
            x, y = x + step_x, y + step_y
            cell = self.cell(x, y)
            if self._hazard[cell]:
                return True
            if self._blocked[cell]:
                return False
        return False

    def _distance(self, marks: list[RectangleMark]) -> Grid:
        """Return the distance of each cell's centre from the nearest rectangle, metres."""
        nearest = np.full(self._x.shape, np.inf)
        for mark in marks:
            aside = np.maximum(mark.x - self._x, self._x - mark.x - mark.width).clip(0.0)
            above = np.maximum(mark.y - self._y, self._y - mark.y - mark.height).clip(0.0)
            np.minimum(nearest, np.hypot(aside, above), out=nearest)
        return nearest

    def _distance_to_bounds(self, scene: Scene) -> Grid:
        """Return the distance of each cell's centre from the edge of the map, metres."""
        aside: Grid = np.minimum(self._x, scene.width - self._x)
        above: Grid = np.minimum(self._y, scene.height - self._y)
        nearest: Grid = np.minimum(aside, above)
        return nearest

    def _graph(self, free: Mask, weight: Grid) -> sparse.csr_array:
        """Join each free cell to sixteen around it, by weighted length in metres.

        Sixteen directions keep path lengths within 3 % of the geodesic; eight, within 8 %.
        """
        columns, rows = self.columns, self.rows
        grid = np.arange(rows * columns).reshape(rows, columns)
        froms, tos, costs = [], [], []
        for right, up in _STEPS:
            low, high = max(0, -up), rows - max(0, up)
            start = grid[low:high, : columns - right].ravel()
            end = start + up * columns + right
            # The two cells that the straight line between both centres passes as well.
            sign = 1 if up > 0 else -1
            passed = {
                (1, 1): (1, sign * columns),
                (2, 1): (1, 1 + sign * columns),
                (1, 2): (sign * columns, 1 + sign * columns),
            }.get((right, abs(up)), ())
            through = [start, end, *(start + offset for offset in passed)]
            usable = np.logical_and.reduce([free[cells] for cells in through])
            mean = np.mean([weight[cells] for cells in through], axis=0)
            froms.append(start[usable])
            tos.append(end[usable])
            costs.append(CELL_M * math.hypot(right, up) * mean[usable])
        size = rows * columns
        return sparse.csr_array(
            (np.concatenate(costs), (np.concatenate(froms), np.concatenate(tos))),
            shape=(size, size),
        )

    def _route(
        self, graph: sparse.csr_array, free: Mask, discs: list[DiscMark], look_ahead: float
    ) -> Route:
        """Run Dijkstra from the discs and follow each cell's way for a look-ahead."""
        away = np.stack([np.hypot(self._x - disc.x, self._y - disc.y) for disc in discs])
        inside = free & (away <= np.array([[disc.radius] for disc in discs])).any(axis=0)
        if not inside.any():
            inside[np.where(free, away.min(axis=0), np.inf).argmin()] = True
        cost, onward, _ = csgraph.dijkstra(
            graph,
            directed=False,
            indices=np.flatnonzero(inside),
            return_predecessors=True,
            min_only=True,
        )
        reached = np.isfinite(cost)
        everywhere = np.arange(cost.size)
        onward = np.where(reached & ~inside, onward, everywhere)
        place, travelled = everywhere.copy(), np.zeros(cost.size)
        for _ in range(math.ceil(look_ahead / CELL_M)):
            following = np.where(travelled < look_ahead, onward[place], place)
            travelled += np.hypot(
                self._x[following] - self._x[place], self._y[following] - self._y[place]
            )
            place = following
        nearest = away.argmin(axis=0)
        centre_x = np.array([disc.x for disc in discs])[nearest]
        centre_y = np.array([disc.y for disc in discs])[nearest]
        aim_x = np.where(inside[place], centre_x[place], self._x[place])
        aim_y = np.where(inside[place], centre_y[place], self._y[place])
        # A robot pressed against a wall is in a blocked cell: it thinks from the free one beside.
        beside = ndimage.distance_transform_edt(
            ~reached.reshape(self.rows, self.columns), return_distances=False, return_indices=True
        )
        source = (beside[0] * self.columns + beside[1]).ravel()
        return Route(cost[source], aim_x[source], aim_y[source])


def difference(aim: float, heading: float) -> float:
    """Return the turn from ``heading`` to ``aim``, radians in [-pi, pi), left positive."""
    return (aim - heading + math.pi) % (2.0 * math.pi) - math.pi


@functools.lru_cache(maxsize=8)
def plan_for(scene: Scene, hazard_cost: float, clearance: float, look_ahead: float) -> Plan:
    """Return the plan of a map, built once for each map and taste.

    Args:
        scene: the map as shown.
        hazard_cost: extra metres that a metre of hazard counts.
        clearance: metres kept from walls and hazards where there is room.
        look_ahead: metres along the way at which one aims.
    """
    return Plan(scene, hazard_cost, clearance, look_ahead)
