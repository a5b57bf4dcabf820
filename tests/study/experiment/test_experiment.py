"""The experiment's parts: paired fleets, choices, agreement, and trials that repeat."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from small_experiment import small_experiment
from study.errors import ProtocolError
from study.events.codes import Outcome
from study.experiment.choices import asked_choices, first_rows, free_choices, joined
from study.experiment.driving import drive
from study.experiment.fleets import Fleets, Floats, States, drawn_actions
from study.experiment.protocol import load_experiment, parse_experiment
from study.experiment.trial import run_trial
from study.experiment.world import World
from study.scorers.base import Scorer
from study.scorers.random import RandomScorer
from study.tasks import navigation


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    """A small world."""
    loaded = load_experiment(str(small_experiment(tmp_path_factory.mktemp("world"))))
    return World(loaded.protocol, 5)


def _fleets(fleets: int, *, paired: bool) -> Fleets:
    parameters = {"horizon": 5}
    return Fleets(navigation, parameters, fleets=fleets, robots=3, seed=1, name="x", paired=paired)


def test_paired_fleets_differ_only_by_what_is_done() -> None:
    """Equal actions keep them equal over many respawns; one other action changes one robot."""
    fleets = _fleets(2, paired=True)
    for _ in range(12):
        fleets.step(np.full((2, 3), navigation.FORWARD, np.int32))
        np.testing.assert_array_equal(fleets.states[0], fleets.states[1])
    assert fleets.endings[:, Outcome.TIME_UP].tolist() == [6, 6]
    actions = np.full((2, 3), navigation.FORWARD, np.int32)
    actions[1, 2] = navigation.TURN_LEFT
    fleets.step(actions)
    assert (fleets.states[0] != fleets.states[1]).any(axis=-1).tolist() == [False, False, True]


def test_unpaired_fleets_do_not_depend_on_how_many_there_are() -> None:
    """The first fleet of one is the first of three, over respawns; the others are others."""
    one, three = _fleets(1, paired=False), _fleets(3, paired=False)
    for _ in range(12):
        one.step(np.zeros((1, 3), np.int32))
        three.step(np.zeros((3, 3), np.int32))
        np.testing.assert_array_equal(one.states[0], three.states[0])
    assert (three.states[0] != three.states[1]).any()


def test_actions_are_drawn_by_their_chances() -> None:
    """A mark falls into the action's part of the line from 0 to 1."""
    chances = np.tile([0.5, 0.0, 0.25, 0.25], (5, 1))
    marks = np.array([0.0, 0.49, 0.5, 0.74, 0.99])
    assert drawn_actions(chances, marks).tolist() == [0, 0, 2, 2, 3]


def test_fewer_choices_are_the_first_of_more(world: World) -> None:
    """Data amount is turned by leaving choices out, and by nothing else."""
    few, many = (free_choices(world, world.phi, 1.0, runs) for runs in (1, 3))
    for name, array in first_rows(many, len(few["chosen"])).items():
        np.testing.assert_array_equal(array, few[name])


def test_choices_follow_luce(world: World) -> None:
    """At a low temperature the best is chosen; at a high one all about equally often."""
    best = free_choices(world, world.phi, 1e-6, 2)
    worth = world.phi.scores(best["states"].reshape(-1, 4)).reshape(-1, 4)
    np.testing.assert_array_equal(worth.argmax(axis=1), best["chosen"])
    any_one = free_choices(world, world.phi, 1e6, 20)
    counts = np.bincount(any_one["chosen"], minlength=4)
    assert np.abs(counts / counts.sum() - 0.25).max() < 0.08


def test_a_correction_round_asks_about_a_few(world: World) -> None:
    """As many choices as asked for, among as many robots; joined, the first stay first."""
    asked = asked_choices(world, world.phi, 7)
    assert asked["states"].shape == (7, 4, 4)
    free = free_choices(world, world.phi, 1.0, 1)
    both = joined(free, asked)
    assert len(both["chosen"]) == len(free["chosen"]) + 7
    np.testing.assert_array_equal(both["states"][: len(free["chosen"])], free["states"])
    assert set(both["trials"][-7:]) == {int(free["trials"].max()) + 1}


def test_agreement_and_reward_of_fleets(world: World) -> None:
    """Phi agrees with itself always, its reverse never, a random scorer about once in n."""

    class Reverse:
        def scores(self, states: States) -> Floats:
            return -world.phi.scores(states)

    scorers: dict[str, Scorer] = {
        "ground_truth": world.phi,
        "reverse": Reverse(),
        "random": RandomScorer(),
    }
    runs = drive(
        world, world.phi, scorers, dwells=(1, 5), robots=6, timesteps=200, name="x",
        unassisted=True,
    )  # fmt: skip
    found = {(run.scorer, run.dwell): run for run in runs}
    assert set(found) == {*((s, d) for s in scorers for d in (1, 5)), ("none", 0)}
    assert found["ground_truth", 5].own_agreement == 1.0
    assert found["reverse", 1].own_agreement == found["reverse", 1].reference_agreement == 0.0
    assert abs(found["random", 1].reference_agreement - 1 / 6) < 0.1
    assert len(found["none", 0].demonstrations.actions) == 0
    assert all(np.isfinite(run.team_reward) for run in runs)


def test_a_run_does_not_depend_on_who_else_runs(world: World) -> None:
    """A scorer's fleet earns the same alone and beside others: pairing shares, never mixes."""
    every: dict[str, Scorer] = {"ground_truth": world.phi, "random": RandomScorer()}
    both = drive(world, world.phi, every, dwells=(1, 5), robots=4, timesteps=40, name="x")
    alone = drive(
        world, world.phi, {"ground_truth": world.phi}, dwells=(5,), robots=4, timesteps=40, name="x"
    )
    rewards = {(run.scorer, run.dwell): run.team_reward for run in both}
    assert [rewards["ground_truth", 5]] == [run.team_reward for run in alone if run.dwell == 5]


def test_a_trial_repeats_and_its_sets_share_no_world(tmp_path: Path) -> None:
    """Equal numbers give equal rows; another number or set gives another world."""
    protocol = load_experiment(str(small_experiment(tmp_path))).protocol
    first = run_trial(protocol, "held_out", 2)
    assert first == run_trial(protocol, "held_out", 2)
    seeds = {run["worlds"][0]["seed"] for run in (first, run_trial(protocol, "development", 2))}
    assert len(seeds) == 2


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("development = 20200531", "development = 20261126", "they must differ"),
        ('scorer = "luce"', 'scorer = "luse"', 'did you mean "luce"?'),
        ('name = "lowest_health"', 'name = "low_health"', "unknown scorer"),
        ("temperature = 1.0", "temperature = 0.0", "phase_two.temperature"),
        ("[experiment]", "[study]", "study run"),
        ("[scorers.health]", "[scorers.none]", "taken by the program"),
        ("asked = 4", "asked = 40", "only 12 robots"),
        ("hidden = [32, 32]", "hiden = [32, 32]", "scorers.luce.parameters.hiden"),
    ],
)
def test_problems_are_named(tmp_path: Path, old: str, new: str, problem: str) -> None:
    """What is wrong with a file is said with its key path."""
    path = small_experiment(tmp_path, **{old: new})
    with pytest.raises(ProtocolError) as error:
        parse_experiment(path.read_text(), str(path))
    assert problem in str(error.value)
