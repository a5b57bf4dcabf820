"""What another choice would have earned."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from choosing_study import choosing_study
from study.commands.whatif import open_sessions
from study.events.codes import Outcome
from study.experiment.fleets import drawn_actions
from study.simulated.trained_user import TrainedUser
from study.whatif.regret import (
    DEMONSTRATIONS,
    RegretSettings,
    RollingOut,
    open_rollouts,
)
from study.whatif.running import ask
from study.whatif.sessions import ChoiceSession, FleetRun

SETTINGS = RegretSettings(horizon=12, draws=2, choices=6)


@pytest.fixture(scope="module")
def sessions(tmp_path_factory: pytest.TempPathFactory) -> list[ChoiceSession]:
    """The choices of two participants."""
    return open_sessions(
        choosing_study(tmp_path_factory.mktemp("choosing"), 2, trials=2, timesteps=30)
    )


def opened(session: ChoiceSession, settings: RegretSettings = SETTINGS) -> RollingOut:
    """Return a session ready to be rolled out."""
    rollouts = open_rollouts(session, settings, pytest.fail)
    assert rollouts is not None
    return rollouts


def exact_value(rollouts: RollingOut, run: FleetRun, at: int, taken_over: int) -> float:
    """Return what a whole fleet earns, robot by robot, if one robot is taken over at a choice."""
    settings, states = rollouts.settings, run.states[run.rows[at]]
    seeds, marks = rollouts._luck(run, np.array([at]))
    policy, user = rollouts.policies[run.started.policy_id], rollouts.driver
    assert isinstance(user, TrainedUser)
    robots, total = len(states), 0.0
    every = np.ones(robots, np.bool_)
    for draw in range(settings.draws):
        task = rollouts.make_task(robots)
        task.reset(every, seeds[0, :, draw])
        now, running = task.place(every, states), every
        for timestep in range(settings.horizon):
            actions: npt.NDArray[np.int32] = policy.actions(now, np.random.default_rng(0)).copy()
            chances = user.probabilities(now[taken_over : taken_over + 1])
            mark = marks[0, taken_over, draw, timestep : timestep + 1]
            actions[taken_over] = drawn_actions(chances, mark)[0]
            step = task.step(actions, running)
            total += float(step.rewards.astype(np.float64).sum())
            now, running = step.states, step.outcomes == Outcome.RUNNING
    return total / settings.draws


def test_regret_is_zero_for_the_best_by_exact_rollouts(sessions: list[ChoiceSession]) -> None:
    """Rolling the whole fleet forward under each alternative names the same robots and losses."""
    rollouts = opened(sessions[0])
    run = next(run for run in sessions[0].runs if run.started.phase == 3)
    picked = np.array([2, 17])
    gains = rollouts.gains(run, picked)
    for place, at in enumerate(picked):
        robots = gains.shape[1]
        exact = np.array([exact_value(rollouts, run, int(at), i) for i in range(robots)])
        assert gains[place].argmax() == exact.argmax()
        assert gains[place].max() - gains[place] == pytest.approx(exact.max() - exact, abs=1e-3)
        assert np.ptp(exact) > 0.5


def test_the_best_choice_has_no_regret_and_others_have_some(
    sessions: list[ChoiceSession],
) -> None:
    """In the table: 0 exactly where the robot is the best, never below 0."""
    many = dataclasses.replace(SETTINGS, choices=40)
    table = ask(sessions[:1], ["own", "random", "lowest_health"], regret=many).tables["regret"]
    rows = range(len(table["who"]))
    best = [at for at in rows if table["robot"][at] == table["best"][at]]
    assert best
    assert all(table["regret"][at] == 0.0 for at in best)
    assert all(table["regret"][at] >= 0.0 for at in rows)
    assert any(table["regret"][at] > 0.0 for at in rows if table["who"][at] == "operator")
    everybody = ("operator", "chance", "own", "random", "lowest_health")
    assert {who: table["who"].count(who) for who in set(table["who"])} == dict.fromkeys(
        everybody, 40
    )
    for at in rows:
        gap = table["best_gain"][at] - table["gain"][at]
        assert table["regret"][at] == pytest.approx(gap, abs=2e-6)


def test_a_choice_is_rolled_out_alike_whatever_is_beside_it(
    sessions: list[ChoiceSession],
) -> None:
    """Luck is keyed by the choice: alone, in company and in another order it is the same."""
    rollouts = opened(sessions[1])
    run = sessions[1].runs[-1]
    together = rollouts.gains(run, np.array([3, 8, 21]))
    assert np.array_equal(together[[2, 0, 1]], rollouts.gains(run, np.array([21, 3, 8])))
    assert np.array_equal(together[1], rollouts.gains(run, np.array([8]))[0])


def test_relabelled_robots_keep_their_gains_on_average(sessions: list[ChoiceSession]) -> None:
    """With the robots the other way round the gains are too, but for luck: most are near."""
    run = sessions[0].runs[-1]
    turned = dataclasses.replace(run, states=run.states[:, ::-1], available=run.available[:, ::-1])
    rollouts = opened(sessions[0], RegretSettings(horizon=10, draws=24, choices=1))
    gains = rollouts.gains(run, np.array([5]))[0]
    other = rollouts.gains(turned, np.array([5]))[0][::-1]
    assert np.corrcoef(gains, other)[0, 1] > 0.9


def test_other_drivers_drive(sessions: list[ChoiceSession]) -> None:
    """The participant's own demonstrations instead of the trained user; not an unknown name."""
    own = opened(sessions[0], dataclasses.replace(SETTINGS, driver=DEMONSTRATIONS))
    run = sessions[0].runs[-1]
    assert not np.array_equal(
        own.gains(run, np.array([1])), opened(sessions[0]).gains(run, np.array([1]))
    )
    with pytest.raises(Exception, match='no driver "nobody"'):
        opened(sessions[0], dataclasses.replace(SETTINGS, driver="nobody"))


def test_a_task_that_has_changed_is_not_rolled_out(sessions: list[ChoiceSession]) -> None:
    """The note says why; nothing is made up."""
    notes: list[str] = []
    older = dataclasses.replace(sessions[0], task=dataclasses.replace(sessions[0].task, version=0))
    assert open_rollouts(older, SETTINGS, notes.append) is None
    assert notes == ["No regret: the task navigation is not what it was when this was recorded."]
    strange = dataclasses.replace(
        sessions[0], task=dataclasses.replace(sessions[0].task, name="unheard_of")
    )
    assert open_rollouts(strange, SETTINGS, notes.append) is None
    assert "unknown task" in notes[1]


def test_a_robot_that_cannot_be_placed_is_a_note(sessions: list[ChoiceSession]) -> None:
    """Of such a fleet run there is no regret."""
    run = sessions[0].runs[-1]
    states = run.states.copy()
    states[:, :, 3] = 0.0
    broken = dataclasses.replace(sessions[0], runs=(dataclasses.replace(run, states=states),))
    found = ask([broken], ["lowest_health"], regret=SETTINGS)
    assert not found.tables["regret"]["who"]
    assert any("cannot be put where it was" in note for note in found.notes)
