"""Laps driven by a simulated operator in the real arena, by what screens show."""

from __future__ import annotations

import math

import numpy as np
import pytest

from extras import need
from simulated_world import Policy, World
from study.arena.course import TWO_BUCKETS
from study.arena.laps import Progress, advance
from study.screens import Tile
from study.seeding import generator
from study.simulated.driving import effort_to_go
from study.simulated.laps import LapSkill, LapWay, lap_parameters
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import OperatorParameters, draw_parameters
from study.tasks import jetbot
from study.tasks.base import SnapshotTask

need("mujoco")

SCENE = TWO_BUCKETS.scene()
PARAMETERS = lap_parameters(OperatorParameters())
IDLE = 4


def tile(x: float, y: float, heading: float, robot: int = 0) -> Tile:
    """Return a robot as shown."""
    return Tile(robot, x, y, heading, 100.0, None, 1)


def tile_of(state: np.ndarray, robot: int = 0) -> Tile:
    """Return a robot as shown in a state of the task."""
    x, y, heading = map(float, state[:3])
    return tile(x, y, heading, robot)


def idle(states: np.ndarray) -> np.ndarray:
    """Robots that stand still by themselves."""
    return np.full(len(states), IDLE, np.int32)


def world(robots: int, allocation: str, policy: Policy, seed: int) -> World:
    """Return a fleet run with the task jetbot, at the 8 timesteps a second of the stand-in."""
    task = jetbot.create(robots, {})
    assert isinstance(task, SnapshotTask)
    return World(robots, allocation, policy, seed=seed, dwell=40, task=task)


def test_the_way_is_a_lap() -> None:
    """Followed once, it passes every gate forwards, clear of buckets and walls."""
    way, progress = LapWay(SCENE), Progress()
    x, y = 2.05, 0.9
    for _ in range(400):
        aim_x, aim_y = way.ahead(x, y)
        away = math.hypot(aim_x - x, aim_y - y)
        to_x, to_y = x + 0.02 * (aim_x - x) / away, y + 0.02 * (aim_y - y) / away
        progress = advance(TWO_BUCKETS, progress, (x, y), (to_x, to_y))
        x, y = to_x, to_y
        assert all(
            math.hypot(each.x - x, each.y - y) > each.radius + 0.15 for each in TWO_BUCKETS.buckets
        )
        assert 0.3 < x < 3.7
        assert 0.3 < y < 2.7
    assert progress.laps == 1


def test_effort_goes_on_falling_from_lap_to_lap() -> None:
    """What is left falls by what is driven; across the finish line it does not jump."""
    way = LapWay(SCENE)
    before = effort_to_go(way, tile(1.9, 0.85, 0.0), PARAMETERS)
    after = effort_to_go(way, tile(2.1, 0.85, 0.0), PARAMETERS, near=before)
    assert after == pytest.approx(before - 0.2, abs=0.05)
    assert effort_to_go(way, tile(2.1, 0.85, 0.0), PARAMETERS) > before + way.period / 2
    backwards = effort_to_go(way, tile(2.1, 0.85, math.pi), PARAMETERS, near=after)
    assert backwards > after + 0.4


@pytest.mark.parametrize("seed", range(3))
def test_it_drives_laps(seed: int) -> None:
    """In a minute at least one; left alone, or at random, a robot does none."""
    operator = SimulatedOperator(draw_parameters(1, seed), seed)
    run = world(1, "manual", idle, seed)
    assert sum(float(run.step(operator).rewards.sum()) for _ in range(480)) >= 1.0
    random = np.random.default_rng(seed)
    onlooker = SimulatedOperator(draw_parameters(1, seed), seed)
    alone = world(1, "none", lambda states: random.integers(0, 5, 1).astype(np.int32), seed)
    assert sum(float(alone.step(onlooker).rewards.sum()) for _ in range(480)) == 0.0


def test_it_takes_over_who_gets_nowhere() -> None:
    """Of three robots two drive laps by themselves; it goes to the third and stays mostly there."""
    hands = [LapSkill(PARAMETERS, generator(5, "hands", robot)) for robot in range(3)]
    keys = {"up": 0, "down": 1, "left": 2, "right": 3, "": IDLE}

    def two_drive(states: np.ndarray) -> np.ndarray:
        tiles = [tile_of(state, robot) for robot, state in enumerate(states)]
        for robot, hand in enumerate(hands):
            hand.look(SCENE, tiles, robot)
        pressed = [keys[hand.key(each)] for hand, each in zip(hands, tiles, strict=True)]
        return np.array([*pressed[:2], IDLE], np.int32)

    run = world(3, "manual", two_drive, 4)
    operator = SimulatedOperator(draw_parameters(3, 0), 3)
    operated = [run.step(operator).screen.operated for _ in range(400)]
    assert operated.count(2) > 0.6 * len(operated), operated


def test_a_way_that_is_blocked_is_gone_round() -> None:
    """Straight ahead is somebody: it turns aside; hemmed in, it waits, then backs."""
    skill = LapSkill(PARAMETERS.model_copy(update={"steering_lapse": 0.0}), generator(1, "hands"))
    aim_x, aim_y = LapWay(SCENE).ahead(2.0, 0.87)
    own = tile(2.0, 0.87, math.atan2(aim_y - 0.87, aim_x - 2.0))
    skill.look(SCENE, (own,), 0)
    assert skill.key(own) == "up"
    skill.look(
        SCENE, (own, tile(2.0 + 0.7 * (aim_x - 2.0), 0.87 + 0.7 * (aim_y - 0.87), 0.0, 1)), 0
    )
    assert skill.key(own) in {"left", "right"}
    around = [
        tile(2.0 + 0.3 * math.cos(angle), 0.87 + 0.3 * math.sin(angle), 0.0, robot)
        for robot, angle in enumerate(np.linspace(-2, 2, 7), start=1)
    ]
    skill.look(SCENE, (own, *around), 0)
    pressed = [skill.key(own) for _ in range(14)]
    assert pressed[0] == ""
    assert pressed[-1] == "down"


def test_it_corrects_who_errs_alone() -> None:
    """A robot that drives laps by itself is let, one that does not is driven."""
    stuck = world(1, "correction", idle, 6)
    operator = SimulatedOperator(draw_parameters(6, 0), 6)
    rows = [stuck.step(operator) for _ in range(240)]
    assert sum(row.action >= 0 for row in rows) > 60
    able = LapSkill(PARAMETERS, generator(7, "hands"))
    keys = {"up": 0, "down": 1, "left": 2, "right": 3, "": IDLE}

    def drives(states: np.ndarray) -> np.ndarray:
        own = tile_of(states[0])
        able.look(SCENE, (own,), 0)
        return np.array([keys[able.key(own)]], np.int32)

    well = world(1, "correction", drives, 6)
    operator = SimulatedOperator(draw_parameters(6, 0), 6)
    rows = [well.step(operator) for _ in range(240)]
    assert sum(row.action >= 0 for row in rows) < 60
