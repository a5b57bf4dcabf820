"""Measures of attention: small fleets worked out by hand."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.attention import FleetLog, attended, measures, stretches, stuck
from analysis.recordings import StudyRecordings
from analysis.results import StudyResults, compute_results
from analysis.sections import attention
from analysis.statistics.result import EffectResult, Refusal
from analysis.tables.attention import MEASURES, build
from analysis.tables.study_tables import StudyTables
from study.events.codes import ActionSource, ChoiceFlag, Outcome

POLICY, OPERATOR, IDLE = ActionSource.POLICY, ActionSource.OPERATOR, ActionSource.OPERATOR_IDLE
GONE = ActionSource.INACTIVE


def fleet(operated: list[int], robots: int = 2, span: int | None = 3) -> FleetLog:
    """A run in which the operator always acts, nobody ends and every robot drives off."""
    steps = len(operated)
    sources = np.full((steps, robots), int(POLICY), np.int64)
    for step, robot in enumerate(operated):
        if robot >= 0:
            sources[step, robot] = OPERATOR
    away = 2.0 * np.arange(steps)[:, None, None] * np.ones((1, robots, 2))
    return FleetLog(
        operated=np.array(operated, np.int64),
        flags=np.zeros(steps, np.int64),
        sources=sources,
        running=np.ones((steps, robots), np.bool_),
        outcomes=np.zeros((steps, robots), np.int64),
        rewards=np.zeros((steps, robots)),
        places=away,
        stuck_timesteps=span,
        presses=None,
    )


def test_stretches_are_runs_of_equal_values() -> None:
    """Start, length and value of each; nothing of nothing."""
    starts, lengths, values = stretches(np.array([4, 4, -1, 4, 4, 4]))
    assert starts.tolist() == [0, 2, 3]
    assert lengths.tolist() == [2, 1, 3]
    assert values.tolist() == [4, -1, 4]
    assert [len(each) for each in stretches(np.zeros(0, np.int64))] == [0, 0, 0]


def test_dwell_and_takeovers() -> None:
    """Robots 0, 1, 0 for 3, 2 and 1 timesteps after one without: 3 takeovers, dwell 2."""
    found = measures(fleet([-1, 0, 0, 0, 1, 1, 0]))
    assert found["takeovers"] == 3
    assert found["dwell"] == 2.0
    assert found["attended"] == pytest.approx(6 / 7)


def test_robots_passed_on_the_way_are_not_attended_to() -> None:
    """Cycling past robot 1 is no takeover of it, and what comes before a selection is none."""
    log = fleet([0, 0, 1, 2, 2], robots=3)
    flags = np.array([ChoiceFlag.BEFORE_FIRST_SELECTION, 0, ChoiceFlag.CYCLING, 0, 0])
    log = dataclasses.replace(log, flags=flags)
    assert attended(log).tolist() == [-1, 0, -1, 2, 2]
    found = measures(log)
    assert found["takeovers"] == 2
    assert found["dwell"] == 1.5


def test_switch_lag() -> None:
    """From leaving to the first action: 1 way and 2 idle, then a takeover without any action."""
    log = fleet([0, 0, -1, 1, 1, 1, 0, 0])
    sources = log.sources.copy()
    sources[3:5, 1] = IDLE
    sources[6:8, 0] = IDLE
    assert measures(dataclasses.replace(log, sources=sources))["switch_lag"] == (3 + 2) / 2
    assert math.isnan(measures(fleet([0, 0, 0]))["switch_lag"])


def test_switch_cost() -> None:
    """Settled at 2 points a timestep; in the first 8 timesteps 1, 1, 1, 2, 2, 2, 2, 2: 3 lost."""
    log = fleet([0] * 12)
    rewards = np.zeros((12, 2))
    rewards[:, 0] = [1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2]
    rewards[:, 1] = 99.0
    assert measures(dataclasses.replace(log, rewards=rewards))["switch_cost"] == 3.0
    assert math.isnan(measures(fleet([0, 0, 1, 1]))["switch_cost"])


def test_switch_cost_of_two_takeovers() -> None:
    """The second is left after 2 timesteps at half the pace: (0 + 2) / 2 takeovers."""
    log = fleet([0] * 10 + [1] * 2)
    rewards = np.zeros((12, 2))
    rewards[:10, 0] = 2.0
    rewards[10:, 1] = 1.0
    assert measures(dataclasses.replace(log, rewards=rewards))["switch_cost"] == 1.0


def test_neglect_time() -> None:
    """Robot 0 alone for 2, robot 1 for 3; robot 2 for 4, ended for 1, then alone for 0."""
    log = fleet([0, 0, 0, 1, 1], robots=3)
    running = log.running.copy()
    running[4, 2] = False
    assert measures(dataclasses.replace(log, running=running))["neglect_time"] == (2 + 3 + 4) / 3


def test_a_robot_is_stuck_after_standing_still() -> None:
    """With a span of 3: still from timestep 2 on, so stuck from 5; a metre and more is moving."""
    log = fleet([0] * 8)
    assert log.places is not None
    places = log.places.copy()
    places[2, 1] = [10.0, 10.0]
    places[3:, 1] = [10.9, 9.0]
    places[7, 1] = [12.0, 10.0]
    found = stuck(dataclasses.replace(log, places=places))
    assert found is not None
    assert found[:, 1].tolist() == [False] * 5 + [True, True, False]
    assert not found[:, 0].any()


def test_an_episode_that_ended_is_not_stuck() -> None:
    """A robot that stood still across an episode's end begins anew."""
    log = fleet([0] * 8)
    places = np.zeros((8, 2, 2))
    running = log.running.copy()
    running[3, 1] = False
    found = stuck(dataclasses.replace(log, places=places, running=running))
    assert found is not None
    assert found[:, 1].tolist() == [False] * 7 + [True]


def stuck_fleet(operated: list[int]) -> FleetLog:
    """Robot 1 stands still throughout; robot 0 drives."""
    log = fleet(operated)
    assert log.places is not None
    places = log.places.copy()
    places[:, 1] = 0.0
    return dataclasses.replace(log, places=places)


def test_the_wait_of_a_stuck_robot() -> None:
    """Stuck from timestep 3, taken over at 7: it waited 4; left at 9, stuck till the end."""
    found = measures(stuck_fleet([0] * 7 + [1] * 2 + [0] * 3))
    assert found["stuck_spells"] == 2
    assert found["stuck_helped"] == 0.5
    assert found["stuck_wait"] == 4.0
    # Unattended: robot 0 for 2, robot 1 for 7 + 3, of which stuck 4 + 3.
    assert found["stuck_share"] == pytest.approx(7 / 12)


def test_neglect_tolerance_and_fan_out() -> None:
    """5 timesteps without trouble, one robot that got stuck: 5; dwell 4: fan-out 2.25."""
    found = measures(stuck_fleet([0] * 7 + [1] * 2 + [0] * 3))
    assert found["neglect_tolerance"] == 5.0
    assert found["dwell"] == 4.0
    assert found["fan_out"] == 5 / 4 + 1
    assert found["fan_out_with_wait"] == 5 / (4 + 4) + 1


def test_a_lost_robot_is_trouble_too() -> None:
    """Robot 1 is lost, alone, after 4 timesteps, and that is all: tolerance 4."""
    log = fleet([0] * 6)
    outcomes = log.outcomes.copy()
    outcomes[3, 1] = Outcome.LOST
    running = log.running.copy()
    running[4:, 1] = False
    found = measures(dataclasses.replace(log, outcomes=outcomes, running=running))
    assert found["neglect_tolerance"] == 4.0
    assert found["stuck_spells"] == 0
    assert math.isnan(found["stuck_wait"])


def test_return_on_effort() -> None:
    """12 points, 4 timesteps acted, 6 presses."""
    log = fleet([0, 0, 1, 1, -1])
    log = dataclasses.replace(log, rewards=np.full((5, 2), 1.2), presses=6)
    found = measures(log)
    assert found["actions"] == 4
    assert found["reward_per_action"] == pytest.approx(3.0)
    assert found["reward_per_press"] == pytest.approx(2.0)
    assert math.isnan(measures(dataclasses.replace(log, presses=None))["reward_per_press"])


@pytest.mark.parametrize("lacking", ["places", "stuck_timesteps"])
def test_what_cannot_be_told_is_missing(lacking: str) -> None:
    """Without places or a rate nobody is seen to be stuck; the rest is measured all the same."""
    log = stuck_fleet([0, 0, 1, 1])
    found = measures(dataclasses.replace(log, **{lacking: None}))  # type: ignore[arg-type]
    assert math.isnan(found["stuck_spells"])
    assert math.isnan(found["fan_out"])
    assert found["dwell"] == 2.0


@st.composite
def logs(draw: st.DrawFn) -> FleetLog:
    """Any fleet run."""
    steps, robots = draw(st.integers(1, 30)), draw(st.integers(2, 5))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    operated = np.repeat(random.integers(-1, robots, steps), 3)[:steps].astype(np.int64)
    running = random.random((steps, robots)) < 0.9
    sources: npt.NDArray[np.int64] = np.where(running, int(POLICY), int(GONE)).astype(np.int64)
    for step, robot in enumerate(operated):
        if robot >= 0:
            running[step, robot] = True
            sources[step, robot] = random.choice([OPERATOR, IDLE])
    return FleetLog(
        operated=operated,
        flags=random.choice([0, 0, 0, int(ChoiceFlag.CYCLING)], steps),
        sources=sources,
        running=running,
        outcomes=random.choice([0, 0, 0, int(Outcome.LOST)], (steps, robots)),
        rewards=random.integers(-4, 5, (steps, robots)) / 2.0,
        places=np.cumsum(random.normal(0, 0.4, (steps, robots, 2)), axis=0),
        stuck_timesteps=3,
        presses=int(random.integers(0, 9)),
    )


@given(logs(), st.randoms(use_true_random=False))
def test_measures_do_not_hang_on_what_robots_are_called(log: FleetLog, random: object) -> None:
    """The same fleet under other numbers gives the same measures, to the last bit."""
    names = list(range(log.running.shape[1]))
    random.shuffle(names)  # type: ignore[attr-defined]
    place = np.argsort(names)
    assert log.places is not None
    other = dataclasses.replace(
        log,
        operated=np.where(log.operated < 0, -1, place[np.maximum(log.operated, 0)]),
        sources=log.sources[:, names],
        running=log.running[:, names],
        outcomes=log.outcomes[:, names],
        rewards=log.rewards[:, names],
        places=log.places[:, names],
    )
    assert measures(other) == pytest.approx(measures(log), abs=0, rel=0, nan_ok=True)


@given(logs())
def test_measures_stay_in_their_range(log: FleetLog) -> None:
    """Shares from 0 to 1, times not below 0, fan-out at least 1, every declared name."""
    found = measures(log)
    assert list(found) == [column.name for column in MEASURES]
    for name in ("attended", "stuck_helped", "stuck_share"):
        assert math.isnan(found[name]) or 0.0 <= found[name] <= 1.0
    for name in ("dwell", "switch_lag", "neglect_time", "stuck_wait", "neglect_tolerance"):
        assert math.isnan(found[name]) or found[name] >= 0.0
    assert math.isnan(found["fan_out"]) or found["fan_out"] >= 1.0
    steps = len(log.operated)
    assert math.isnan(found["dwell"]) or found["dwell"] * found["takeovers"] <= steps + 1e-9


def test_the_table_has_a_row_for_each_run_with_an_operator(study: StudyRecordings) -> None:
    """Fleets of two and more, not those that drive alone; no keys in these recordings."""
    frame = build(study).frame
    assert set(frame["phase"]) == {2, 3}
    assert (frame["robots"] >= 2).all()
    whole = frame[frame["participant"] == "P01"]
    assert len(whole) == 3 + 2 * 3
    assert frame["presses"].isna().all()
    # Twelve timesteps, eight on each robot: two takeovers, of 8 and 4 timesteps.
    assert (whole["takeovers"] == 2).all()
    assert (whole["dwell"] == 6.0).all()


def test_order_of_records_does_not_matter(study: StudyRecordings) -> None:
    """Sessions given the other way round give the same rows."""
    turned = dataclasses.replace(study, sessions=study.sessions[::-1])
    keys = ["participant", "trial_id"]
    first = build(study).frame.astype({"participant": str}).sort_values(keys)
    second = build(turned).frame.astype({"participant": str}).sort_values(keys)
    assert first[["dwell", "switch_cost"]].equals(
        second[["dwell", "switch_cost"]].set_index(first.index)
    )


def test_conditions_are_compared_and_what_is_absent_is_said(
    study: StudyRecordings, tables: StudyTables
) -> None:
    """Tests are Holm-adjusted over the measures; missing ones have their reason in words."""
    results: StudyResults = compute_results(study, tables)
    rows = attention.rows(results)
    by_key = {row.key: row for row in rows}
    assert "presses" not in by_key
    actions = by_key["actions"]
    assert actions.trials[0] == actions.trials[1] > 0
    reward = by_key["reward_per_action"]
    assert isinstance(reward.test, EffectResult)
    assert reward.holm_p is not None
    assert reward.holm_p >= reward.test.p
    absent = attention.absent(results, rows)
    assert all(isinstance(each, Refusal) for each in absent)
    said = {each.reason for each in absent}
    assert "These recordings hold no keys or buttons." in said
    assert any("the same for every participant" in reason for reason in said)
    assert attention.finding(results, rows)
    assert attention.figure(results, rows) is not None
