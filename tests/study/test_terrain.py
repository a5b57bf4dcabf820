"""Distances and places agree with computations that share no code with them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from study.layouts import named_layout
from study.terrain import Terrain

STEP = 0.2


def _on_floor(x: float, y: float) -> bool:
    """The three rooms' floor, walls that no robot passes left out."""
    if abs(x - 9.4) < 1e-9 and y < 7.1 and not 3.95 <= y <= 5.85:
        return False
    if abs(y - 7.0) < 1e-9 and x > 9.4 and not 16.45 <= x <= 18.65:
        return False
    return 0 <= x <= 20 and 0 <= y <= 15 and (x >= 9.4 or y < 7.0)


def _crossing_allowed(ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether a straight step crosses walls only where a robot passes."""
    if (ax - 9.4) * (bx - 9.4) < -1e-9:
        crossing = ay + (by - ay) * (9.4 - ax) / (bx - ax)
        if not 3.95 <= crossing <= 5.85:
            return False
    if (ay - 7.0) * (by - 7.0) < -1e-9:
        crossing = ax + (bx - ax) * (7.0 - ay) / (by - ay)
        if not 16.45 <= crossing <= 18.65:
            return False
    return True


def _grid_distances() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Dijkstra's distances to the goal on a grid with steps in many directions."""
    columns, rows = round(20 / STEP), round(15 / STEP)
    places = [(i * STEP, j * STEP) for i in range(columns + 1) for j in range(rows + 1)]
    index = {
        (round(x / STEP), round(y / STEP)): k
        for k, (x, y) in enumerate([place for place in places if _on_floor(*place)])
    }
    xy = np.array([(i * STEP, j * STEP) for i, j in index])
    goal = len(xy)
    offsets = [(i, j) for i, j in itertools.product(range(-4, 5), repeat=2) if math.gcd(i, j) == 1]
    edges = []
    for (i, j), here in index.items():
        for di, dj in offsets:
            there = index.get((i + di, j + dj))
            if there is not None and _crossing_allowed(*xy[here], *xy[there]):
                edges.append((here, there, STEP * math.hypot(di, dj)))
        to_goal = math.hypot(xy[here][0] - 11.3, xy[here][1] - 12.7)
        if to_goal < 1.5:
            edges.append((goal, here, to_goal))
    starts, ends, lengths = zip(*edges, strict=True)
    graph = coo_array((lengths, (starts, ends)), shape=(goal + 1, goal + 1)).tocsr()
    return xy, np.asarray(dijkstra(graph, indices=np.array([goal])))[0, :goal]


def test_goal_distances_agree_with_dijkstra() -> None:
    """Everywhere the distance is the grid's, less the detours that a grid makes."""
    xy, on_grid = _grid_distances()
    exact = Terrain(named_layout("three_rooms")).goal_distance(xy[:, 0], xy[:, 1])
    assert np.isfinite(on_grid).all()
    assert (exact <= on_grid + 0.02).all()
    assert (on_grid <= 1.01 * exact + 0.25).all()
    assert exact.max() > 25


def test_goal_distance_is_continuous_at_doors() -> None:
    """A robot that crosses a door gains what it drives and nothing more."""
    terrain = Terrain(named_layout("three_rooms"))
    y = np.linspace(3.95, 5.85, 301)
    before = terrain.goal_distance(np.full(301, 9.4 - 1e-6), y)
    after = terrain.goal_distance(np.full(301, 9.4 + 1e-6), y)
    assert np.abs(before - after).max() < 0.016


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        (1.6, 1.4, {"legal"}),
        (4.0, 3.0, {"legal", "hazard"}),
        (1.6, 5.9, {"legal", "pack"}),
        (11.3, 13.6, {"legal", "goal"}),
        (9.4, 5.0, {"legal"}),
        (9.4, 3.8, set()),
        (9.2, 1.0, set()),
        (18.0, 7.1, {"legal"}),
        (5.0, 10.0, set()),
        (0.3, 3.0, set()),
        (13.1, 9.9, {"legal", "hazard"}),
    ],
)
def test_places_are_what_the_layout_says(x: float, y: float, expected: set[str]) -> None:
    """Doorways are legal, walls and the empty quadrant are not; edges belong to hazards."""
    terrain = Terrain(named_layout("three_rooms"))
    here = np.array([x]), np.array([y])
    answers = {
        "legal": terrain.is_legal(*here),
        "hazard": terrain.in_hazard(*here),
        "pack": terrain.at_pack(*here),
        "goal": terrain.at_goal(*here),
    }
    assert {name for name, answer in answers.items() if answer[0]} == expected
