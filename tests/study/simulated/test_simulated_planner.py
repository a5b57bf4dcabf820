"""The grid plan that operators drive by."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.events.scene import DiscMark, RectangleMark, Scene
from study.layouts import named_layout
from study.simulated.planner import CELL_M, Plan, plan_for
from study.terrain import Terrain

LAYOUT = named_layout("three_rooms")
TERRAIN = Terrain(LAYOUT)
OPEN = Scene(20.0, 15.0, (), (DiscMark("goal", 10.0, 7.0, 0.5),), None, 0.3)


def free_places(count: int, seed: int = 3) -> list[tuple[float, float]]:
    """Draw places where a robot can be, outside hazards."""
    random = np.random.default_rng(seed)
    x = random.uniform(0.0, LAYOUT.width, 20 * count)
    y = random.uniform(0.0, LAYOUT.height, 20 * count)
    free = TERRAIN.is_legal(x, y) & ~TERRAIN.in_hazard(x, y)
    return list(zip(x[free][:count].tolist(), y[free][:count].tolist(), strict=True))


@given(st.floats(0.6, 19.4), st.floats(0.6, 14.4))
def test_cost_in_the_open_is_distance(x: float, y: float) -> None:
    """Without obstacles the cost is the distance to the goal's edge, to a cell and 3 %."""
    plan = plan_for(OPEN, 4.0, 0.0, 1.0)
    distance = max(0.0, math.hypot(x - 10.0, y - 7.0) - 0.5)
    assert plan.goal.cost[plan.cell(x, y)] == pytest.approx(distance, rel=0.03, abs=2 * CELL_M)


def test_cost_equals_the_geodesic() -> None:
    """Without a taste for hazards or clearance the cost is the task's own driving distance."""
    plan = plan_for(LAYOUT.scene(), 0.0, 0.0, 1.0)
    places = free_places(2000)
    x, y = (np.array(axis) for axis in zip(*places, strict=True))
    geodesic = TERRAIN.goal_distance(x, y) - LAYOUT.goal.radius
    cost = np.array([plan.goal.cost[plan.cell(*place)] for place in places])
    error = cost - np.maximum(geodesic, 0.0)
    assert error.min() > -2 * CELL_M
    assert (error < 3 * CELL_M + 0.08 * geodesic).all()
    assert np.corrcoef(cost, geodesic)[0, 1] > 0.999


@given(st.floats(0.0, 10.0), st.floats(0.0, 1.0))
@settings(max_examples=20)
def test_tastes_only_add_cost(hazard_cost: float, clearance: float) -> None:
    """Avoiding hazards and walls never makes a way cheaper than the plain geodesic."""
    plain = Plan(LAYOUT.scene(), 0.0, 0.0, 1.0).goal.cost
    wary = Plan(LAYOUT.scene(), hazard_cost, clearance, 1.0).goal.cost
    assert all(more >= less - 1e-9 for more, less in zip(wary, plain, strict=True))


def test_aims_lead_to_the_goal_round_hazards() -> None:
    """Walking from aim to aim reaches the goal, and never enters a hazard on the way."""
    plan = plan_for(LAYOUT.scene(), 4.0, 0.6, 0.5)
    for place in free_places(300):
        cell = plan.cell(*place)
        for _ in range(300):
            x, y = plan.goal.aim_x[cell], plan.goal.aim_y[cell]
            assert not plan.in_hazard(x, y)
            cell = plan.cell(x, y)
        assert plan.goal.cost[cell] <= 0.0


def test_blocked_places_are_thought_of_from_beside() -> None:
    """Every place on and off the map has a finite cost and aim."""
    plan = plan_for(LAYOUT.scene(), 4.0, 0.6, 1.0)
    assert np.isfinite(plan.goal.cost).all()
    assert np.isfinite(plan.goal.aim_x).all()
    assert 0 <= plan.cell(-3.0, 99.0) < plan.rows * plan.columns


def test_hazard_ahead_stops_at_reach_and_walls() -> None:
    """A hazard counts as ahead within reach and in line, but not behind a wall."""
    scene = Scene(
        20.0,
        15.0,
        (RectangleMark("hazard", 8.0, 0.0, 2.0, 15.0), RectangleMark("wall", 12.0, 0.0, 0.2, 15.0)),
        (DiscMark("goal", 2.0, 7.0, 0.5),),
        None,
        0.3,
    )
    plan = plan_for(scene, 4.0, 0.0, 1.0)
    assert plan.in_hazard(9.0, 5.0)
    assert plan.hazard_ahead(7.0, 5.0, 0.0, 1.5)
    assert not plan.hazard_ahead(7.0, 5.0, math.pi, 1.5)
    assert not plan.hazard_ahead(5.0, 5.0, 0.0, 1.5)
    assert not plan.hazard_ahead(13.0, 5.0, math.pi, 5.0)


def test_a_map_without_goal_or_rooms_still_plans() -> None:
    """A bare map has its middle for a goal, and no packs."""
    plan = plan_for(Scene(4.0, 3.0, (), (), None, 0.3), 4.0, 0.6, 1.0)
    assert plan.packs is None
    assert plan.goal.cost[plan.cell(2.0, 1.5)] == 0.0
