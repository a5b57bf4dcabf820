"""Every task keeps the task contract."""

from __future__ import annotations

import numpy as np
import pytest

from extras import need
from study.events.codes import Outcome
from study.events.task_description import TaskDescription
from study.families import known_members, load_member
from study.tasks.base import PicturedTask, SnapshotTask, Task

ROBOTS = 5
EVERY = np.ones(ROBOTS, np.bool_)
EXTRAS = {"doom": ("vizdoom",), "jetbot": ("mujoco",)}
SEEDS = np.arange(10, 10 + ROBOTS, dtype=np.uint64)


ENVIRONMENTS = ("CartPole-v1", "MountainCar-v0", "Acrobot-v1")
"""Of Gymnasium, whose episodes start at different places."""


def _names() -> list[str]:
    names = [name for name in known_members("study.tasks") if name != "gymnasium"]
    return names + [f"gymnasium:{name}" for name in ENVIRONMENTS]


@pytest.fixture(params=_names())
def name(request: pytest.FixtureRequest) -> str:
    """The name of one task; one whose extra is missing is skipped aloud."""
    if request.param.startswith("gymnasium:"):
        pytest.importorskip("gymnasium")
    need(*EXTRAS.get(request.param, ()))
    return str(request.param)


def _create(name: str, robots: int = ROBOTS) -> Task:
    task: Task = load_member("study.tasks", "task", name).create(robots, {})
    assert isinstance(task, Task)
    return task


def _random_actions(
    description: TaskDescription, seed: int
) -> np.ndarray[tuple[int], np.dtype[np.int32]]:
    random = np.random.default_rng(seed)
    return random.integers(0, len(description.action_names), ROBOTS).astype(np.int32)


def test_modules_offer_the_family_interface(name: str) -> None:
    """A task's module has parameters with descriptions, a description and its process."""
    module = load_member("study.tasks", "task", name)
    assert isinstance(module.OUT_OF_PROCESS, bool)
    for field in module.Parameters.model_fields.values():
        assert field.description
    assert module.describe({}) == module.describe(module.Parameters()) == _create(name).description


def test_descriptions_are_consistent_and_survive_json(name: str) -> None:
    """Names, fields and actions fit together; recorded and read back nothing is lost."""
    description = _create(name).description
    fields = description.state_fields
    assert description.name == name
    assert TaskDescription.from_json(description.to_json()) == description
    assert description.idle_action in range(len(description.action_names))
    assert set(description.key_actions.values()) <= set(range(len(description.action_names)))
    for place in (description.x_field, description.y_field, description.health_field):
        assert -1 <= place < len(fields)
    assert description.heading_field < 0 or fields[description.heading_field].circular
    assert description.resimulable in {"exact", "tolerance", "no"}


def test_shapes_and_ranges(name: str) -> None:
    """States, rewards and outcomes have the declared types, shapes and ranges."""
    task = _create(name)
    fields = task.description.state_fields
    states = task.reset(EVERY, SEEDS)
    assert states.shape == (ROBOTS, len(fields))
    assert states.dtype == np.float32
    for number in range(20):
        step = task.step(_random_actions(task.description, number), EVERY)
        assert step.states.shape == (ROBOTS, len(fields))
        assert step.states.dtype == np.float32
        assert step.rewards.shape == (ROBOTS,)
        assert step.rewards.dtype == np.float32
        assert step.outcomes.shape == (ROBOTS,)
        assert step.outcomes.dtype == np.int32
        assert set(step.outcomes.tolist()) <= set(Outcome)
        for place, field in enumerate(fields):
            assert field.low < field.high
            if field.bounded:
                assert (step.states[:, place] >= field.low).all()
                assert (step.states[:, place] <= field.high).all()
    task.close()
    task.close()


def test_inactive_robots_are_untouched(name: str) -> None:
    """Robots that are not stepped keep their state and outcome and earn nothing."""
    task = _create(name)
    before = task.reset(EVERY, SEEDS)
    active = np.array([True, False, True, False, False])
    step = task.step(_random_actions(task.description, 0), active)
    assert step.states[~active].tobytes() == before[~active].tobytes()
    assert step.rewards[~active].tolist() == [0.0] * 3
    assert step.outcomes[~active].tolist() == [Outcome.RUNNING] * 3
    assert (step.states[active] != before[active]).any()


def test_reset_touches_only_its_robots(name: str) -> None:
    """Others keep their states; what was returned before does not change in hindsight."""
    task = _create(name)
    before = task.reset(EVERY, SEEDS)
    kept = before.copy()
    some = np.array([False, True, False, False, True])
    after = task.reset(some, SEEDS + np.uint64(100))
    assert after[~some].tobytes() == before[~some].tobytes()
    assert (after[some] != before[some]).any(axis=1).all()
    assert before.tobytes() == kept.tobytes()


def test_episodes_end_by_the_horizon(name: str) -> None:
    """No robot runs longer than declared, and an ended one stays as it is."""
    module = load_member("study.tasks", "task", name)
    short = {
        "erratic": {"horizon": 15, "slowest_ms": 0.0},
        "jetbot": {"episode_seconds": 1.5, "timesteps_per_second": 10.0},
    }
    task = module.create(ROBOTS, short.get(name, {"horizon": 15}))
    task.reset(EVERY, SEEDS)
    idle = np.full(ROBOTS, task.description.idle_action, np.int32)
    for _ in range(15):
        last = task.step(idle, EVERY)
    assert (last.outcomes != Outcome.RUNNING).all()
    again = task.step(idle, EVERY)
    assert again.states.tobytes() == last.states.tobytes()
    assert again.outcomes.tolist() == last.outcomes.tolist()
    assert not again.rewards.any()


def test_what_is_declared_exact_repeats(name: str) -> None:
    """A task that declares itself resimulable repeats states and rewards to the byte."""
    if _create(name).description.resimulable != "exact":
        pytest.skip("not declared to repeat exactly")
    runs = []
    for _ in range(2):
        task = _create(name)
        parts = [task.reset(EVERY, SEEDS).tobytes()]
        for number in range(60):
            step = task.step(_random_actions(task.description, number), EVERY)
            parts += [step.states.tobytes(), step.rewards.tobytes(), step.outcomes.tobytes()]
        runs.append(parts)
    assert runs[0] == runs[1]


def test_pictures_are_of_every_robot(name: str) -> None:
    """A task whose scene is a camera's takes a picture a robot; robots not stepped keep theirs."""
    task = _create(name)
    assert isinstance(task, PicturedTask) == task.description.scene.camera
    if not isinstance(task, PicturedTask):
        return
    task.reset(EVERY, SEEDS)
    before = task.pictures()
    assert before.shape[0] == ROBOTS
    assert before.ndim in {4, 5}
    assert before.shape[-1] == 3
    assert before.dtype == np.uint8
    active = np.array([True, False, True, False, False])
    for number in range(30):
        task.step(_random_actions(task.description, number), active)
    after = task.pictures()
    assert after[~active].tobytes() == before[~active].tobytes()
    assert (after[active] != before[active]).reshape(2, -1).any(axis=1).all()


def test_snapshots_repeat_the_future(name: str) -> None:
    """A task that offers snapshots goes on from one as it did the first time."""
    task = _create(name)
    if not isinstance(task, SnapshotTask):
        pytest.skip("offers no snapshots")
    task.reset(EVERY, SEEDS)
    snapshot = task.snapshot()
    futures = []
    for _ in range(2):
        task.restore(snapshot)
        steps = [task.step(_random_actions(task.description, k), EVERY) for k in range(30)]
        futures.append([step.states.tobytes() for step in steps])
    assert futures[0] == futures[1]
