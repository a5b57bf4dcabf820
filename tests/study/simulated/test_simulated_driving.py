"""Driving in the real navigation task, and correcting robots that drive themselves."""

from __future__ import annotations

import numpy as np
import pytest

from simulated_world import (
    Policy,
    World,
    drive_home,
    idle_policy,
    random_policy,
    tile_of,
)
from study.events.codes import Outcome
from study.layouts import named_layout
from study.screens import Tile, WaitScreen
from study.simulated.driving import CorrectionMonitor, Driver, effort_to_go
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import OperatorParameters, draw_parameters
from study.simulated.planner import plan_for
from study.tasks.navigation import BACKWARD, IDLE, TURN_RIGHT
from study.terrain import Terrain

PARAMETERS = OperatorParameters()
LAYOUT = named_layout("three_rooms")
PLAN = plan_for(
    LAYOUT.scene(), PARAMETERS.hazard_cost, PARAMETERS.clearance_m, PARAMETERS.look_ahead_m
)


def test_drives_home_from_the_tasks_starts() -> None:
    """At least 95 % of robots reach the goal, with far more points than robots left alone."""
    runs = [
        drive_home(
            SimulatedOperator(draw_parameters(1, seed), seed),
            World(1, "manual", idle_policy, seed=seed),
        )
        for seed in range(40)
    ]
    assert np.mean([outcome == Outcome.GOAL for outcome, _ in runs]) >= 0.95
    assert np.mean([reward for _, reward in runs]) > 20.0


def test_drives_home_from_anywhere() -> None:
    """At least 95 % reach the goal from random places, headings and health."""
    random = np.random.default_rng(5)
    terrain = Terrain(LAYOUT)
    outcomes: list[int] = []
    while len(outcomes) < 40:
        x, y = random.uniform(0, LAYOUT.width, 1), random.uniform(0, LAYOUT.height, 1)
        if not terrain.is_legal(x, y)[0] or terrain.in_hazard(x, y)[0] or terrain.at_goal(x, y)[0]:
            continue
        place = np.array(
            [[x[0], y[0], random.uniform(-3.1, 3.1), random.uniform(30, 100)]], np.float32
        )
        seed = len(outcomes)
        operator = SimulatedOperator(draw_parameters(2, seed), seed)
        world = World(1, "manual", idle_policy, seed=seed, places=place)
        outcomes.append(drive_home(operator, world)[0])
    assert np.mean([outcome == Outcome.GOAL for outcome in outcomes]) >= 0.95


def test_effort_falls_by_a_step_while_on_track() -> None:
    """Under a driver, effort-to-go falls by 0.4 to 1.2 forward steps a timestep on average."""
    world = World(1, "manual", idle_policy, seed=3)
    operator = SimulatedOperator(PARAMETERS.model_copy(update={"pack_health": 0.0}), 3)
    rows = [world.step(operator) for _ in range(70)]
    efforts = [effort_to_go(PLAN, row.screen.tiles[0], PARAMETERS) for row in rows[10:]]
    fall = (efforts[0] - efforts[-1]) / (len(efforts) - 1) / PARAMETERS.forward_step_m
    assert 0.4 < fall < 1.2


def test_backs_out_of_a_hazard_that_it_faces() -> None:
    """A robot with its nose in a hazard reverses instead of turning round in it."""
    world = World(1, "manual", idle_policy, places=np.array([[3.75, 3.3, 0.0, 80.0]], np.float32))
    operator = SimulatedOperator(PARAMETERS.model_copy(update={"hazard_cost": 20.0}), 1)
    actions = [world.step(operator).action for _ in range(12)]
    assert BACKWARD in actions
    assert not Terrain(LAYOUT).in_hazard(*world.states[:, :2].T.astype(float))[0]


def test_fetches_a_pack_when_worn() -> None:
    """A worn robot near a pack is healed before it goes on; a sound one goes straight on."""
    for health, healed in ((30.0, True), (100.0, False)):
        places = np.array([[3.0, 5.4, 0.0, health]], np.float32)
        world = World(1, "manual", idle_policy, places=places)
        operator = SimulatedOperator(PARAMETERS, 1)
        rows = [world.step(operator) for _ in range(60)]
        gain = max(float(row.states[0, 3]) for row in rows) - health
        assert (gain > 20.0) is healed


def test_a_spent_pack_is_left() -> None:
    """A pack that does not heal is left for the goal, not waited at for ever."""
    driver = Driver(PARAMETERS.model_copy(update={"steering_lapse": 0.0}), np.random.default_rng(1))
    pack = LAYOUT.packs[0]
    keys = [driver.key(PLAN, Tile(0, pack.x, pack.y, 0.0, 20.0, None, 1)) for _ in range(40)]
    waited = keys.index("")
    assert "" not in keys[waited + 8 :]
    assert "up" in keys[waited:]


def test_a_stalled_robot_is_freed() -> None:
    """A robot that does not move although driven forward is reversed."""
    driver = Driver(PARAMETERS.model_copy(update={"steering_lapse": 0.0}), np.random.default_rng(1))
    cell = PLAN.cell(16.0, 1.5)
    aim = np.arctan2(PLAN.goal.aim_y[cell] - 1.5, PLAN.goal.aim_x[cell] - 16.0)
    keys = [driver.key(PLAN, Tile(0, 16.0, 1.5, float(aim), 100.0, None, 1)) for _ in range(8)]
    assert keys[0] == "up"
    assert "down" in keys


def corrected_share(policy: Policy, seed: int) -> float:
    """Return the share of an episode's timesteps in which the operator overrides the robot."""
    world = World(1, "correction", policy, seed=seed)
    operator = SimulatedOperator(PARAMETERS, 2)
    driven = []
    for _ in range(200):
        row = world.step(operator)
        driven.append(row.action >= 0)
        if row.outcomes[0] != Outcome.RUNNING:
            break
    return float(np.mean(driven))


def test_correction_leaves_good_robots_alone() -> None:
    """A robot that drives as the operator would is little corrected, one at random mostly."""
    codes = {"up": 0, "down": 1, "left": 2, "right": 3, "": IDLE}

    def expert(seed: int) -> Policy:
        driver = Driver(PARAMETERS, np.random.default_rng(seed))
        return lambda states: np.array([codes[driver.key(PLAN, tile_of(states[0]))]], np.int32)

    good = [corrected_share(expert(seed), seed) for seed in range(6)]
    poor = [corrected_share(random_policy(seed), seed) for seed in range(6)]
    assert np.mean(good) < 0.35
    assert np.mean(poor) > 0.6


@pytest.mark.parametrize("turns", [False, True])
def test_correction_threshold_is_timesteps_of_no_progress(turns: bool) -> None:
    """Standing still is corrected after threshold / 0.5 timesteps; turning away sooner."""
    monitor = CorrectionMonitor(PARAMETERS)
    cell = PLAN.cell(3.0, 1.0)
    heading = float(np.arctan2(PLAN.goal.aim_y[cell] - 1.0, PLAN.goal.aim_x[cell] - 3.0))
    step = np.radians(15.0) if turns else 0.0
    tiles = [Tile(0, 3.0, 1.0, heading - step * k, 100.0, None, 1) for k in range(20)]
    taken = [monitor.update(PLAN, tile, 0) for tile in tiles].index(True)
    assert taken == (1 if turns else 2)


def test_ten_corrected_episodes_are_good_demonstrations() -> None:
    """Episodes that start from a random policy all reach the goal, mostly hand-driven."""
    operator = SimulatedOperator(draw_parameters(3, 0), 0)
    actions, outcomes = [], []
    for episode in range(10):
        operator.act(WaitScreen("Ready", "", -1.0), 0)
        world = World(1, "correction", random_policy(episode), seed=episode)
        for _ in range(200):
            row = world.step(operator)
            actions.append(row.action)
            if row.outcomes[0] != Outcome.RUNNING:
                outcomes.append(row.outcomes[0])
                break
    assert outcomes.count(Outcome.GOAL) >= 9
    driven = [action for action in actions if 0 <= action <= TURN_RIGHT]
    assert len(driven) > 0.6 * len(actions)
    assert len(set(driven)) >= 3
