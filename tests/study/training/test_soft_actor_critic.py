"""The learner where the answer is known in closed form, and on the task."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import torch

from study.simulated.rollouts import States, roll_out
from study.tasks import navigation
from study.training import user
from study.training.soft_actor_critic import ActorCriticParameters, Learner, Memory, train
from study.training.user import course_of, make_user, measured_values

ALPHA, GAMMA = 0.5, 0.9
SMALL = ActorCriticParameters(
    hidden=(32, 32), temperature=ALPHA, discount=GAMMA, averaging=0.05, learning_rate=0.003
)
TINY = ActorCriticParameters(
    hidden=(16, 16), updates=60, robots=8, first_timesteps=20, batch_size=32, memory=1000
)


def _softly(values: npt.NDArray[np.float64]) -> float:
    return float(ALPHA * np.log(np.exp(values / ALPHA).sum()))


def test_policy_and_critics_reach_the_soft_optimum_of_two_states() -> None:
    """In A each action earns its points and leads to B, where each earns its own and all ends.

    There Q is what is earned; in A it is that and the discounted soft value of B; and the policy
    is the softmax of Q over the temperature (Haarnoja et al., 2018, equations 2 to 4).
    """
    earned = {"A": np.array([0.0, 1.0, -1.0]), "B": np.array([2.0, 1.5, 0.0])}
    memory = Memory(6, 2)
    a, b = np.eye(2)
    for action in range(3):
        chosen = np.array([action], np.int32)
        memory.add(
            a[None], chosen, np.array([earned["A"][action]], np.float32), b[None], np.array([True])
        )
        memory.add(
            b[None], chosen, np.array([earned["B"][action]], np.float32), b[None], np.array([False])
        )
    torch.set_num_threads(1)
    torch.manual_seed(1)
    learner, random = Learner(2, 3, SMALL), np.random.default_rng(1)
    for done in range(2000):
        learner.update(memory.draw(32, random), max(0.01, 1 - done / 2000))

    both = torch.eye(2)
    q = learner.critics(both).mean(dim=0).detach().numpy()
    wanted = np.stack([earned["A"] + GAMMA * _softly(earned["B"]), earned["B"]])
    assert q == pytest.approx(wanted, abs=0.05)
    chances = learner.actor(both).softmax(dim=1).detach().numpy()
    best = np.exp(wanted / ALPHA)
    assert chances == pytest.approx(best / best.sum(axis=1, keepdims=True), abs=0.02)
    drawn = learner.act(np.repeat(a[None], 20_000, axis=0), random)
    assert np.bincount(drawn, minlength=3) / 20_000 == pytest.approx(chances[0], abs=0.02)


def test_the_oldest_transitions_are_overwritten() -> None:
    """Of five that were added to room for three, the latest three are drawn."""
    memory = Memory(3, 1)
    for number in range(5):
        value = np.array([[float(number)]])
        memory.add(value, np.array([0], np.int32), np.zeros(1, np.float32), value, np.array([True]))
    now, *_ = memory.draw(200, np.random.default_rng(1))
    assert set(now[:, 0].tolist()) == {2.0, 3.0, 4.0}


def test_the_same_seed_gives_the_same_network() -> None:
    """Weights, starts, noise, actions and minibatches are all keyed by it."""
    course = course_of("navigation", {})

    def trained(seed: int) -> list[npt.NDArray[np.float64]]:
        fleet = course.fleet(TINY.robots, horizon=TINY.episode_timesteps)
        return [
            array for layer in train(fleet, course.spread, TINY, seed).layers for array in layer
        ]

    first, again, other = trained(1), trained(1), trained(2)
    assert all(np.array_equal(x, y) for x, y in zip(first, again, strict=True))
    assert not all(np.array_equal(x, y) for x, y in zip(first, other, strict=True))


def test_a_made_user_says_how_it_was_made_and_how_good_its_values_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The file's metadata hold the command and an R^2 that anybody can compute again."""
    monkeypatch.setattr(user, "VALUE_TIMESTEPS", 10)
    course = course_of("navigation", {})
    made = make_user(course, TINY, 3, "a command")
    assert made.user.made_of["command"] == "a command"
    assert made.user.made_of["values_measured"] == {"states": 400, "rollouts": 25}
    assert made.user.made_of["values_r_squared"] == pytest.approx(made.values_r_squared, abs=1e-4)


def test_measured_values_of_a_policy_are_its_mean_returns() -> None:
    """An idle robot far from everything loses a timestep's points for as long as it counts."""

    class Idle:
        def actions(self, states: States, random: np.random.Generator) -> npt.NDArray[np.int32]:
            """Return idle for each state."""
            return np.full(len(states), navigation.IDLE, np.int32)

    course = course_of("navigation", {"hazard_damage": 0.0, "pack_heal": 0.0})
    found = measured_values(course, Idle(), 0.99, 1, states=10, rollouts=2)
    rest = (1 - 0.99**600) / (1 - 0.99)
    assert found.values == pytest.approx(np.full(10, -0.05 * rest), abs=1e-3)
    again = roll_out(
        course.fleet(10, horizon=600),
        Idle(),
        np.arange(10, dtype=np.uint64),
        np.random.default_rng(1),
        states=found.states,
    )
    assert again.returns(0.99)[0] == pytest.approx(found.values, abs=1e-3)
