"""The JetBots' task: motion, collisions, laps, cameras."""

from __future__ import annotations

import itertools
import math
import sys
from pathlib import Path
from typing import TypeGuard

import numpy as np
import pytest

from extras import need
from lap_driver import BACKWARD, FORWARD, IDLE, TURN_LEFT, TURN_RIGHT, lap_action
from study.arena.cameras import FrontCameras, ViewFromAbove, open_cameras
from study.arena.course import MOST_ROBOTS, ROBOT_RADIUS, TWO_BUCKETS
from study.arena.model import arena_mjcf
from study.arena.physics import ArenaPhysics, wheel_speeds
from study.commands.simulating import simulate_study
from study.durations import dwell_seconds
from study.errors import ProtocolError, StudyError
from study.events.codes import Outcome, Phase
from study.events.task_description import TaskDescription
from study.loading import load_protocol, missing_extra
from study.session.plan import StagePlan, TrialPlan
from study.session.sequence import stage_plans
from study.tasks import jetbot
from study.tasks.base import PicturedTask

need("mujoco")

EXACT = {"noise": 0.0, "wheel_bias": 0.0}


def fleet(robots: int, **parameters: object) -> jetbot.JetbotTask:
    """Return a fleet just reset."""
    task = jetbot.create(robots, parameters)
    assert isinstance(task, jetbot.JetbotTask)
    task.reset(np.ones(robots, np.bool_), np.arange(robots, dtype=np.uint64))
    return task


def drive(task: jetbot.JetbotTask, actions: list[int], timesteps: int) -> np.ndarray:
    """Hold actions; return the states at the end."""
    for _ in range(timesteps):
        step = task.step(np.array(actions, np.int32), np.ones(task.robots, np.bool_))
    return step.states


def test_actions_are_velocities() -> None:
    """Each key moves a robot as its parameters say, after the motors' lag."""
    task = fleet(1, **EXACT)
    for action, axis, speed in [(FORWARD, 0, 0.25), (BACKWARD, 0, -0.15), (IDLE, 0, 0.0)]:
        drive(task, [action], 8)
        assert task.physics.velocities()[0, axis] == pytest.approx(speed, abs=0.01)
    for action, rate in [(TURN_LEFT, 1.5), (TURN_RIGHT, -1.5)]:
        drive(task, [action], 8)
        # Wheels of some width slip a little when they turn on the spot.
        assert task.physics.velocities()[0, 1] == pytest.approx(rate, rel=0.15)


def test_the_motors_lag() -> None:
    """Within a time constant of a command a robot has not reached its speed."""
    physics = ArenaPhysics(TWO_BUCKETS, 1, motor_lag_s=0.2)
    physics.put(0, 2.5, 0.6, 0.0)
    physics.set_wheels(0, *wheel_speeds(0.25, 0.0))
    moving = np.ones(1, np.bool_)
    physics.advance(20, moving)
    assert 0.02 < physics.velocities()[0, 0] < 0.2
    physics.advance(200, moving)
    assert physics.velocities()[0, 0] == pytest.approx(0.25, abs=0.01)


def test_noise_comes_from_the_seed() -> None:
    """The same seed drives the same way to the bit, another one does not."""
    ends = []
    for seed in (1, 1, 2):
        task = fleet(1)
        task.reset(np.ones(1, np.bool_), np.array([seed], np.uint64))
        ends.append(drive(task, [FORWARD], 20).tobytes())
    assert ends[0] == ends[1] != ends[2]


def test_walls_buckets_and_robots_stop_robots() -> None:
    """A robot that drives on against something stays outside of it."""
    task = fleet(3, **EXACT)
    task.physics.put(0, 3.6, 0.5, 0.0)
    task.physics.put(1, 0.9, 1.5, 0.0)
    task.physics.put(2, 1.7, 1.5, math.pi)
    states = drive(task, [FORWARD] * 3, 40)
    assert 3.8 < states[0, 0] < 4.0 - 0.05
    assert 1.3 - states[1, 0] > 0.15 + 0.05
    assert states[2, 0] - 1.3 > 0.15 + 0.05
    task.physics.put(0, 2.6, 0.5, 0.0)
    task.physics.put(1, 3.2, 0.5, math.pi)
    states = drive(task, [FORWARD, FORWARD, IDLE], 30)
    assert states[1, 0] - states[0, 0] > 0.1


def test_a_robot_that_is_not_stepped_is_no_ghost() -> None:
    """It stands to the bit where it stood, and stops who drives into it."""
    task = fleet(2, **EXACT)
    task.physics.put(0, 2.6, 0.5, 0.0)
    task.physics.put(1, 3.0, 0.5, 0.0)
    one = np.array([True, False])
    before = task.physics.poses()[1]
    for _ in range(30):
        step = task.step(np.array([FORWARD, FORWARD], np.int32), one)
    assert (task.physics.poses()[1] == before).all()
    assert 2.6 < step.states[0, 0] < 3.0 - 0.1


def test_starts_are_apart_and_behind_the_finish_line() -> None:
    """However many start, none starts in another; resets look out for those that drive."""
    task = jetbot.create(MOST_ROBOTS, {})
    every = np.ones(MOST_ROBOTS, np.bool_)
    for seed in range(20):
        states = task.reset(every, np.arange(MOST_ROBOTS, dtype=np.uint64) + np.uint64(100 * seed))
        places = states[:, :2].astype(float)
        apart = np.linalg.norm(places[:, None] - places[None], axis=2)
        assert apart[~np.eye(MOST_ROBOTS, dtype=bool)].min() > 2 * ROBOT_RADIUS
        assert (places[:, 0] > 2.0).all()
        assert (places[:, 1] < 1.5).all()


def test_laps_earn_points_and_end_with_the_episode() -> None:
    """A driver of laps earns one point a lap; the state tells the gates; time ends it."""
    task = fleet(1, episode_seconds=90.0)
    states = task.reset(np.ones(1, np.bool_), np.array([3], np.uint64))
    total, passed = 0.0, []
    for _ in range(task.description.horizon):
        x, y, heading, gates = map(float, states[0])
        passed.append(int(gates))
        step = task.step(np.array([lap_action(x, y, heading)], np.int32), np.ones(1, np.bool_))
        states, total = step.states, total + float(step.rewards[0])
    assert total >= 2
    finished = sum(a == 3 and b == 0 for a, b in itertools.pairwise(passed))
    assert total in {finished, finished + 1}
    assert step.outcomes.tolist() == [Outcome.TIME_UP]


def test_too_many_robots_are_refused() -> None:
    """The arena says how many it has room for."""
    with pytest.raises(StudyError, match="room for 1 to 12"):
        jetbot.create(MOST_ROBOTS + 1, {})


def test_seconds_become_timesteps() -> None:
    """An episode's length is given in seconds."""
    assert jetbot.describe({}).horizon == 480
    settings = {"timesteps_per_second": 10.0, "episode_seconds": 2.5}
    assert jetbot.describe(settings).horizon == 25


@pytest.mark.parametrize("name", ["jetbot", "jetbot_simulated"])
def test_the_shipped_studies_have_the_papers_numbers(name: str) -> None:
    """2000 demonstrations, 1300 choices, five one-minute trials, a dwell of 5 s; nothing else."""
    protocol = load_protocol(name).protocol
    rate = protocol.timing.timesteps_per_second
    trials = [plan for plan in stage_plans(protocol, ("manual", "assisted")) if _is_trial(plan)]
    lengths: dict[tuple[Phase, str], list[tuple[int, int]]] = {}
    for plan in trials:
        key = (plan.place.phase, plan.place.condition)
        lengths.setdefault(key, []).append((plan.robots, plan.timesteps))
    practice = lengths.pop((Phase.PRACTICE, ""))
    assert len(practice) == 1
    assert lengths == {
        (Phase.ONE, ""): [(1, 500)] * 4,
        (Phase.TWO, ""): [(2, 325)] * 4,
        (Phase.THREE, "manual"): [(3, round(60 * rate))] * 5,
        (Phase.THREE, "assisted"): [(3, round(60 * rate))] * 5,
    }
    assert protocol.condition("assisted").dwell / rate == 5.0
    assert protocol.questionnaires == ()
    assert protocol.phase_four is None


def _is_trial(plan: StagePlan) -> TypeGuard[TrialPlan]:
    return isinstance(plan, TrialPlan)


def test_the_two_studies_differ_in_where_the_robots_are() -> None:
    """Nothing else: what is rehearsed is what is run."""
    real, simulated = (
        load_protocol(name).protocol.model_dump() for name in ("jetbot", "jetbot_simulated")
    )
    for protocol in (real, simulated):
        del protocol["study"], protocol["assumptions"]
    assert real["task"]["parameters"].pop("link") == "robots.toml"
    assert real["phase_three"].pop("paired_starts") is False
    assert simulated["phase_three"].pop("paired_starts") is True
    assert real == simulated


def test_the_map_is_recorded_with_gates_and_buckets() -> None:
    """Whoever reads a recording can count laps again, and draw the arena, cameras or not."""
    for cameras in (False, True):
        described = jetbot.describe({"cameras": cameras})
        again = TaskDescription.from_json(described.to_json())
        assert again == described
        assert len(again.scene.gates) == len(TWO_BUCKETS.gates)
        assert sum(disc.role == "wall" for disc in again.scene.discs) == 2
        assert again.map_grid is not None
        # Where a bucket is, no robot can be; the middle of the arena is free.
        row, column = again.map_grid.ys.index(1.55), again.map_grid.xs.index(1.35)
        assert again.map_grid.free[row][column] == "0"
        assert again.map_grid.free[row][20] == "1"


def test_the_shipped_study_has_the_papers_times(tmp_path: Path) -> None:
    """A dwell of five seconds, episodes of a minute; another rate than the task's is refused."""
    loaded = load_protocol("jetbot")
    assert [seconds for _, seconds in dwell_seconds(loaded.protocol)] == [5.0]
    rate = loaded.protocol.timing.timesteps_per_second
    assert loaded.description.horizon / rate == 60.0
    other = tmp_path / "jetbot.toml"
    rate_line = "timesteps_per_second = {}.0"
    other.write_text(loaded.text.replace(rate_line.format(10), rate_line.format(11), 1))
    with pytest.raises(ProtocolError, match=r"must be that of timing\.timesteps_per_second, 11"):
        load_protocol(str(other))


def test_the_model_is_the_same_text_each_time() -> None:
    """What is simulated follows from the arguments alone."""
    texts = [arena_mjcf(TWO_BUCKETS, 3, motor_lag_s=0.06, step_s=0.005) for _ in range(2)]
    assert texts[0] == texts[1]
    assert texts[0].count("<freejoint") == 3


def test_tiles_may_show_cameras() -> None:
    """With cameras the task says that it takes pictures, one a robot, in the tile's shape."""
    task = fleet(2, cameras=True)
    assert isinstance(task, PicturedTask)
    scene = task.description.scene
    assert scene.camera
    pictures = task.pictures()
    assert pictures.shape == (2, 120, 160, 3)
    assert scene.width / scene.height == 160 / 120
    assert (pictures[0] != pictures[1]).any()
    blind, actions = fleet(2), [FORWARD, TURN_LEFT]
    seen = drive(task, actions, 10).tobytes()
    task.pictures()
    # Whether somebody looks changes nothing.
    after = drive(task, actions, 10).tobytes()
    assert drive(blind, actions, 10).tobytes() == seen
    assert drive(blind, actions, 10).tobytes() == after
    task.close()
    task.close()


def test_front_cameras_see_what_is_ahead() -> None:
    """The bucket is in the picture of who faces it, and not of who turns away."""
    physics = ArenaPhysics(TWO_BUCKETS, 1, motor_lag_s=0.06)
    cameras = open_cameras(physics)
    if not isinstance(cameras, FrontCameras):
        pytest.skip("no EGL on this machine")

    def yellow(heading: float) -> int:
        physics.put(0, 2.0, 1.5, heading)
        physics.advance(1, np.ones(1, np.bool_))
        red, green, blue = cameras.picture(0).astype(int).transpose(2, 0, 1)
        return int(((red > 1.5 * blue) & (green > 1.3 * blue)).sum())

    assert yellow(0.0) > 200
    assert yellow(math.pi / 2) == 0
    cameras.close()
    cameras.close()


def test_the_view_from_above_shows_robots_where_they_are() -> None:
    """Without EGL the operator sees the arena, the own robot in blue, north at the top."""
    physics = ArenaPhysics(TWO_BUCKETS, 2, motor_lag_s=0.06)
    physics.put(0, 1.0, 2.5, 0.0)
    physics.put(1, 3.0, 0.5, 0.0)
    picture = ViewFromAbove(physics).picture(0)
    assert picture.shape == (120, 160, 3)
    row, column = round(120 - 2.5 / 4 * 160), round(0.98 / 4 * 160)
    assert picture[row, column].tolist() == [41, 120, 181]
    assert picture[round(120 - 0.5 / 4 * 160), round(2.98 / 4 * 160)].tolist() == [148, 60, 50]
    # Both head east: their beaks are ahead of them, and the floor is behind.
    ahead, behind = round(1.16 / 4 * 160), round(0.84 / 4 * 160)
    assert picture[row, ahead].max() < 60
    assert picture[row, behind].min() > 200


@pytest.mark.parametrize(("name", "module"), [("jetbot", "zmq"), ("jetbot_simulated", "mujoco")])
def test_a_missing_extra_is_named_before_anything_runs(
    name: str, module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The protocol is valid without it; validation says what to install, a run begins nothing."""
    loaded = load_protocol(name)
    task = loaded.protocol.task
    monkeypatch.chdir(tmp_path)
    if name == "jetbot":
        assert "robots.toml, which lists the robots" in missing_extra(task.name, task.parameters)
        (tmp_path / "robots.toml").touch()
    assert missing_extra(task.name, task.parameters) == ""
    monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setattr("importlib.util.find_spec", lambda wanted: None)
    said = missing_extra(task.name, task.parameters)
    assert module in said
    assert "pip install 'scaled-autonomy[jetbot]'" in said
    if name == "jetbot_simulated":
        with pytest.raises(StudyError, match="the task jetbot cannot run here"):
            list(simulate_study(name, 1, 1, tmp_path / "out", 1))
        assert not (tmp_path / "out").exists()
