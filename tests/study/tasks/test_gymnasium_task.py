"""Gymnasium's environments as tasks: they behave as they do alone, and refusals are in words."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from protocols import variant
from study.errors import ProtocolError, StudyError
from study.events.codes import Outcome
from study.families import load_member
from study.loading import load_protocol
from study.tasks import navigation
from study.tasks.base import PicturedTask

gymnasium = pytest.importorskip("gymnasium")

ODD = "odd_environments"
EVERY = np.ones(1, np.bool_)
WORD = {"goal": Outcome.GOAL, "lost": Outcome.LOST}


def task_of(env_id: str, robots: int = 1, **parameters: Any) -> PicturedTask:
    """Make a fleet."""
    task: PicturedTask = load_member("study.tasks", "task", f"gymnasium:{env_id}").create(
        robots, parameters
    )
    return task


def seeds(*values: int) -> npt.NDArray[np.uint64]:
    """Return seeds."""
    return np.array(values, np.uint64)


def act(task: PicturedTask, action: int) -> Any:
    """Step a fleet of one."""
    return task.step(np.array([action], np.int32), EVERY)


@pytest.mark.parametrize(
    ("env_id", "ending"),
    [
        ("CartPole-v1", "lost"),
        ("MountainCar-v0", "goal"),
        ("Acrobot-v1", "goal"),
        ("FrozenLake-v1", "goal_if_rewarded"),
        ("CliffWalking-v1", "goal"),
        ("Blackjack-v1", "goal_if_rewarded"),
    ],
)
def test_a_robot_is_the_environment_itself(env_id: str, ending: str) -> None:
    """Observations, rewards and ends are those of the environment alone, by the same seed."""
    alone = gymnasium.make(env_id)
    task = task_of(env_id)
    random = np.random.default_rng(3)
    ended = 0
    for seed in range(6):
        observation, _ = alone.reset(seed=seed)
        states = task.reset(EVERY, seeds(seed))
        for _ in range(60):
            expected = gymnasium.spaces.flatten(alone.observation_space, observation)
            assert states[0].tobytes() == np.asarray(expected, np.float32).tobytes()
            action = int(random.integers(alone.action_space.n))
            observation, reward, terminated, _, _ = alone.step(action)
            step = act(task, action)
            states = step.states
            assert step.rewards[0] == np.float32(reward)
            assert (step.outcomes[0] != Outcome.RUNNING) == terminated
            if terminated:
                ended += 1
                rewarded = Outcome.GOAL if reward > 0 else Outcome.LOST
                assert step.outcomes[0] == WORD.get(ending, rewarded)
                break
    assert ended or env_id in ("MountainCar-v0", "Acrobot-v1", "CliffWalking-v1")


@pytest.mark.parametrize("env_id", ["FrozenLake-v1", "CliffWalking-v1", "Taxi-v4"])
def test_arrows_mean_what_they_look_like(env_id: str) -> None:
    """On a grid each arrow leads to the neighbouring cell that it points to."""
    options = {"is_slippery": False} if env_id != "Taxi-v4" else {}
    task = task_of(env_id, discrete="number", options=options)
    keys = task.description.key_actions
    moved = {}
    env = task._envs[0].unwrapped  # type: ignore[attr-defined]  # nothing else says where it is
    columns = {"FrozenLake-v1": 4, "CliffWalking-v1": 12, "Taxi-v4": 5}[env_id]
    per_cell = 20 if env_id == "Taxi-v4" else 1
    free = {"FrozenLake-v1": 9, "CliffWalking-v1": 17, "Taxi-v4": (2 * 5 + 2) * 20}[env_id]
    for key in ("left", "right", "up", "down"):
        task.reset(EVERY, seeds(1))
        env.s = free
        after = int(act(task, keys[key]).states[0, 0])
        moved[key] = (after - free) // per_cell
    assert moved == {"left": -1, "right": 1, "up": -columns, "down": columns}


def test_carts_and_cars_are_pushed_where_the_key_points() -> None:
    """The right arrow makes them faster to the right than the left one."""
    for env_id, velocity in (("CartPole-v1", 1), ("MountainCar-v0", 1)):
        task = task_of(env_id)
        after = []
        for key in ("left", "right"):
            task.reset(EVERY, seeds(4))
            after.append(act(task, task.description.key_actions[key]).states[0, velocity])
        assert after[0] < after[1]


def test_without_a_key_an_environment_waits() -> None:
    """Where no action does nothing, no key is a timestep in which nothing happens but time."""
    task = task_of("CartPole-v1", horizon=3)
    before = task.reset(EVERY, seeds(4))
    idle = task.description.idle_action
    assert task.description.action_names[idle] == "wait"
    for outcome in (Outcome.RUNNING, Outcome.RUNNING, Outcome.TIME_UP):
        step = act(task, idle)
        assert step.states.tobytes() == before.tobytes()
        assert step.rewards.tolist() == [0.0]
        assert step.outcomes.tolist() == [outcome]


def test_a_protocol_says_what_happens_without_a_key() -> None:
    """What no key does may be what a key does: yet it is another action, no demonstration."""
    task = task_of("CartPole-v1", without_key=0)
    description = task.description
    assert description.idle_action == 2
    assert description.idle_action not in description.key_actions.values()
    task.reset(EVERY, seeds(4))
    without = act(task, description.idle_action).states
    task.reset(EVERY, seeds(4))
    assert act(task, description.key_actions["left"]).states.tobytes() == without.tobytes()
    # An action of no key needs no other number.
    assert task_of("MountainCar-v0").description.idle_action == 1
    assert len(task_of("MountainCar-v0").description.action_names) == 3


def test_the_number_of_a_state_is_one_of_many_or_a_number() -> None:
    """FrozenLake's sixteen cells: sixteen fields, one of them 1; or one field of 0 to 15."""
    many = task_of("FrozenLake-v1")
    assert many.reset(EVERY, seeds(1)).tolist() == [[1.0] + [0.0] * 15]
    assert [field.name for field in many.description.state_fields[:2]] == ["state 0", "state 1"]
    one = task_of("FrozenLake-v1", discrete="number")
    assert one.reset(EVERY, seeds(1)).tolist() == [[0.0]]
    (field,) = one.description.state_fields
    assert (field.low, field.high) == (0.0, 15.0)


def test_ranges_without_bounds_come_from_play() -> None:
    """A cart's velocity has no bound: its range is finite, and the same each time."""
    fields = {field.name: field for field in task_of("CartPole-v1").description.state_fields}
    velocity = fields["cart velocity"]
    assert not velocity.bounded
    assert -6 < velocity.low < -1 < 1 < velocity.high < 6
    assert fields["cart position"].bounded
    assert fields["cart position"].high == pytest.approx(4.8)
    again = task_of("CartPole-v1", horizon=77).description.state_fields
    assert again == tuple(fields.values())


def test_pictures_are_the_environment_s_made_smaller() -> None:
    """A small picture is the environment's own; a large one is averaged over whole blocks."""
    alone = gymnasium.make("FrozenLake-v1", render_mode="rgb_array")
    alone.reset(seed=1)
    task = task_of("FrozenLake-v1")
    task.reset(EVERY, seeds(1))
    assert task.pictures()[0].tobytes() == alone.render().tobytes()
    small = task_of("FrozenLake-v1", picture_width=64)
    small.reset(EVERY, seeds(1))
    blocks = alone.render().reshape(64, 4, 64, 4, 3).astype(int).sum(axis=(1, 3)) // 16
    assert small.pictures()[0].tolist() == blocks.tolist()


def test_environments_of_others() -> None:
    """What a module registers can be named after it; actions get keys of their own."""
    task = task_of(f"{ODD}:Counter-v0", termination="goal")
    description = task.description
    assert description.action_names == (*(f"action {n}" for n in range(5)), "wait")
    assert description.key_actions == {"left": 0, "up": 1, "right": 2, "down": 3, "q": 4}
    assert description.horizon == 30
    task.reset(EVERY, seeds(0))
    outcomes = [int(act(task, 4).outcomes[0]) for _ in range(10)]
    assert outcomes == [Outcome.RUNNING] * 9 + [Outcome.GOAL]
    task.reset(EVERY, seeds(0))
    for action in (*[4] * 9, 3):
        last = act(task, action)
    assert last.outcomes.tolist() == [Outcome.TIME_UP]
    arcade = task_of(f"{ODD}:Arcade-v0", termination="lost").description
    assert arcade.key_actions == {"f": 1, "up": 2, "right": 3, "left": 4}
    assert arcade.action_names[arcade.idle_action] == "NOOP"


@pytest.mark.parametrize(
    ("env_id", "parameters", "words"),
    [
        ("CartPle-v1", {}, 'no environment "CartPle-v1".*Did you mean CartPole-v1'),
        ("CartPole-v7", {}, "Did you mean CartPole-v1"),
        ("", {}, "names no environment"),
        ("nowhere_to_be_found:Pong-v5", {}, "module nowhere_to_be_found"),
        ("Pendulum-v1", {}, "actions of Pendulum-v1 are Box.*keys cannot stand for"),
        ("CartPole-v1", {"options": {"size": 3}}, "CartPole-v1 cannot be made"),
        ("CartPole-v1", {"without_key": 2}, "2 given; CartPole-v1 has actions 0 to 1"),
        ("CartPole-v1", {"keys": {"left": 5}}, "keys.left: 5 given.*0 push left, 1 push right"),
        ("CartPole-v1", {"keys": {"F1": 0}}, '"F1" given.*letters a to z'),
        ("CartPole-v1", {"action_names": ("a",)}, "1 names given; CartPole-v1 has 2"),
        ("CartPole-v1", {"state_names": ("a",)}, "1 names given; a state of CartPole-v1 has 4"),
        (f"{ODD}:Words-v0", {"termination": "goal"}, "no render mode rgb_array, only ansi"),
        (f"{ODD}:Counter-v0", {}, "does not say what it means.*goal_if_rewarded"),
        (
            f"{ODD}:Counter-v0",
            {"termination": "goal", "options": {"size": 5000}},
            "5000 numbers; at most 1024",
        ),
        (
            f"{ODD}:Counter-v0",
            {"termination": "goal", "options": {"actions": 500}},
            "500 actions.*At most 64",
        ),
    ],
)
def test_refusals_are_in_words(env_id: str, parameters: dict[str, Any], words: str) -> None:
    """Each says what was given and what to do."""
    with pytest.raises(StudyError, match=f"(?s){words}") as caught:
        task_of(env_id, **parameters)
    assert caught.value.hint


def test_all_that_does_not_go_with_an_environment_is_told_at_once(tmp_path: Path) -> None:
    """One line each, however many settings it is."""
    wrong = 'keys = { F1 = 0, left = 5 }\naction_names = ["a"]\nstate_names = ["b"]'
    changes = [('"lost"', f'"lost"\n{wrong}'), ('without_key = "wait"', "without_key = 7")]
    path = variant(tmp_path, *changes, base="cart_pole")
    with pytest.raises(ProtocolError) as caught:
        load_protocol(str(path))
    settings = ["action_names", "without_key", "keys", "keys.left", "state_names"]
    said = [problem.split(": ")[0] for problem in caught.value.problems]
    assert said == [f"task.parameters.{name}" for name in settings]


def test_pictures_that_are_none_are_refused() -> None:
    """An environment that draws something else is refused when it is looked at."""
    task = task_of(f"{ODD}:Counter-v0", termination="goal", options={"colour": 1})
    task.reset(EVERY, seeds(1))
    with pytest.raises(StudyError, match="draws arrays of shape"):
        task.pictures()


def test_without_gymnasium_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """The package is an extra."""
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(StudyError, match='extra "gymnasium"'):
        load_member("study.tasks", "task", "gymnasium:CartPole-v1")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("CartPole-v1", "CartPle-v1", 'task.name: no environment "CartPle-v1"'),
        ("gymnasium:CartPole-v1", "gymnasium", 'task: the task "gymnasium" names no environment'),
        ('"lost"', '"won"', "task.parameters.termination: "),
        ('"lost"', '"lost"\nkeys = { q = 0, left = 1 }', ""),
        ('"lost"', '"lost"\nkeys = { space = 0, left = 1 }', '"space" is keys.accept already'),
    ],
)
def test_a_protocol_s_problems_are_named(tmp_path: Path, old: str, new: str, words: str) -> None:
    """They stand among the problems of the file; a free key is none."""
    path = variant(tmp_path, (old, new), base="cart_pole")
    if not words:
        loaded = load_protocol(str(path))
        assert loaded.description.key_actions == {"q": 0, "left": 1}
        return
    with pytest.raises(ProtocolError) as caught:
        load_protocol(str(path))
    assert words in str(caught.value)


def test_descriptions_of_before_stay_the_same_to_the_byte() -> None:
    """What a camera adds to descriptions is not in those of tasks without one."""
    text = navigation.describe({}).to_json()
    assert not any(f'"{name}"' in text for name in ("camera", "bounded", "instruction"))
