"""Who is operated and which key acts, through the whole session."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fake_shell import Alter, FakeShell, Moods
from short_study import opened, short_study
from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource, Outcome
from study.events.events import Event, Paused, Resumed, Switched, Timestep, TimestepSkipped
from study.events.inputs import FocusChanged
from study.session.effects import StepFleet

CALM = Moods(end_chance=0.0)
ENDLESS = Moods(end_chance=0.0, longest_episode=10_000)
LONG = (
    ("trial_timesteps = 6", "trial_timesteps = 90"),
    ("trial_timesteps = 8", "trial_timesteps = 90"),
)


@pytest.fixture
def manual() -> FakeShell:
    """A session in the first trial of phase two: three robots, free choice."""
    shell = FakeShell(opened(short_study(*LONG)), moods=CALM)
    shell.go_to_trial(2)
    shell.moods = ENDLESS
    return shell


@pytest.fixture
def assisted() -> FakeShell:
    """A session at the assisted block's first trial: five robots, dwell 15."""
    loaded = short_study(*LONG, ("dwell = 3", "dwell = 15"))
    shell = FakeShell(opened(loaded, order=("assisted", "manual")), moods=CALM)
    shell.go_to_trial(3, "assisted")
    shell.moods = ENDLESS
    return shell


@pytest.fixture
def correcting() -> FakeShell:
    """A session in phase one's first episode."""
    shell = FakeShell(opened(short_study()), moods=CALM)
    shell.go_to_trial(1)
    return shell


def only_row(events: tuple[Event, ...]) -> Timestep:
    """Return the one timestep among events."""
    (row,) = [event for event in events if isinstance(event, Timestep)]
    return row


def switches(events: Any) -> list[Switched]:
    """Return the switches among events."""
    return [event for event in events if isinstance(event, Switched)]


def answering(**fields: Any) -> Alter:
    """Return what puts fields into the fleet's answer."""

    def alter(made: dict[str, Any]) -> None:
        for name, value in fields.items():
            made[name] = np.array(value, dtype=made[name].dtype)

    return alter


def source(row: Timestep, robot: int) -> ActionSource:
    """Return who decided a robot's action."""
    return ActionSource(row.action_sources[robot])


# Manual choice


def test_nobody_is_operated_before_the_first_selection(manual: FakeShell) -> None:
    """Until a robot is chosen all follow the policy and no row can be fitted."""
    manual.key("up")
    row = only_row(manual.step())
    assert row.operated == -1
    assert row.choice_flag == ChoiceFlag.BEFORE_FIRST_SELECTION
    assert (row.action_sources == ActionSource.POLICY).all()


def test_number_key_chooses_and_is_usable_at_once(manual: FakeShell) -> None:
    """A digit switches to its robot, and the next row is the operator's choice."""
    (switch,) = switches(manual.tap("2"))
    assert (switch.from_robot, switch.to_robot, switch.cause) == (-1, 1, "number")
    row = only_row(manual.step())
    assert (row.operated, row.choice_source) == (1, ChoiceSource.OPERATOR)
    assert row.choice_flag == ChoiceFlag.USABLE
    assert switches(manual.tap("2")) == []


def test_number_beyond_the_fleet_chooses_nothing(manual: FakeShell) -> None:
    """A key for a robot that this fleet has not is without effect."""
    assert switches(manual.tap("4")) == []
    assert only_row(manual.step()).operated == -1


def test_pointer_chooses(manual: FakeShell) -> None:
    """A click on a tile chooses its robot; clicks elsewhere choose none."""
    (switch,) = switches(manual.point("robot:2"))
    assert (switch.to_robot, switch.cause) == (2, "pointer")
    for nowhere in ("robot:3", "robot:-1", "robot:", "confirm", ""):
        assert switches(manual.point(nowhere)) == []


def test_robots_passed_by_tab_are_flagged_until_settled(manual: FakeShell) -> None:
    """Rows after Tab are cycling until the robot is kept for four timesteps."""
    manual.tap("tab")
    (switch,) = switches(manual.tap("tab"))
    assert (switch.from_robot, switch.to_robot, switch.cause) == (0, 1, "tab")
    flags = [only_row(manual.step()).choice_flag for _ in range(6)]
    assert flags == [ChoiceFlag.CYCLING] * 4 + [ChoiceFlag.USABLE] * 2


def test_driving_settles_a_robot_reached_by_tab(manual: FakeShell) -> None:
    """After the first driven timestep the choice is meant."""
    manual.tap("tab")
    manual.key("up")
    flags = [only_row(manual.step()).choice_flag for _ in range(2)]
    assert flags == [ChoiceFlag.CYCLING, ChoiceFlag.USABLE]


def test_tab_goes_round_the_fleet(manual: FakeShell) -> None:
    """After the last robot comes the first again."""
    reached = [switch.to_robot for _ in range(4) for switch in switches(manual.tap("tab"))]
    assert reached == [0, 1, 2, 0]


def test_manual_choice_stays_when_the_robot_ends(manual: FakeShell) -> None:
    """Nothing switches by itself; the row of an ended robot is not available."""
    manual.tap("1")
    manual.step(answering(outcomes=[Outcome.LOST, 0, 0]))
    manual.key("up")
    row = only_row(manual.step())
    assert row.operated == 0
    assert not row.available[0]
    assert source(row, 0) == ActionSource.INACTIVE
    assert switches(manual.events)[-1].cause == "number"


def test_choice_between_due_and_answer_belongs_to_the_next_timestep(manual: FakeShell) -> None:
    """A switch while the fleet steps applies to the step after, and says so."""
    manual.tap("1")
    manual.due()
    (switch,) = switches(manual.tap("3"))
    assert only_row(manual.answer_fleet()).operated == 0
    row = only_row(manual.step())
    assert (row.operated, row.timestep) == (2, switch.timestep)


# Keys that drive


def test_operator_without_a_key_stands_still(manual: FakeShell) -> None:
    """In a fleet an operated robot idles when no key is held."""
    manual.tap("1")
    row = only_row(manual.step())
    assert row.actions[0] == short_study().description.idle_action
    assert source(row, 0) == ActionSource.OPERATOR_IDLE


def test_newest_key_held_acts(manual: FakeShell) -> None:
    """Of two keys held the newer acts; when it is released, the older again."""
    actions = short_study().description.key_actions
    manual.tap("1")
    manual.key("up")
    manual.key("left")
    assert only_row(manual.step()).actions[0] == actions["left"]
    manual.key("left", down=False)
    assert only_row(manual.step()).actions[0] == actions["up"]


def test_tap_shorter_than_a_timestep_acts_once(manual: FakeShell) -> None:
    """A key down and up between two timesteps acts at the next, and only there."""
    manual.tap("1")
    manual.tap("left")
    first, second = only_row(manual.step()), only_row(manual.step())
    assert first.actions[0] == short_study().description.key_actions["left"]
    assert [source(row, 0) for row in (first, second)] == [
        ActionSource.OPERATOR,
        ActionSource.OPERATOR_IDLE,
    ]


def test_key_held_across_a_manual_switch_keeps_acting(manual: FakeShell) -> None:
    """Who switches by hand drives the new robot at once."""
    manual.tap("1")
    manual.key("up")
    manual.tap("2")
    row = only_row(manual.step())
    assert source(row, 1) == ActionSource.OPERATOR
    assert source(row, 0) == ActionSource.POLICY


@pytest.mark.parametrize("by", ["focus", "escape"])
def test_pause_lets_keys_go(manual: FakeShell, by: str) -> None:
    """After a pause a key held before does not act until it is pressed again."""
    manual.tap("1")
    manual.key("up")
    if by == "focus":
        manual.feed(FocusChanged(manual.later(), focused=False))
        manual.feed(FocusChanged(manual.later(), focused=True))
    else:
        manual.tap("escape")
    assert manual.pace == 0
    assert manual.due() == ()
    manual.tap("return")
    assert manual.pace > 0
    paused, resumed = [e for e in manual.events if isinstance(e, Paused | Resumed)]
    assert isinstance(paused, Paused)
    assert isinstance(resumed, Resumed)
    assert paused.reason == ("focus lost" if by == "focus" else "operator")
    assert resumed.paused_ns == resumed.t_ns - paused.t_ns
    assert source(only_row(manual.step()), 0) == ActionSource.OPERATOR_IDLE
    manual.key("up")
    assert source(only_row(manual.step()), 0) == ActionSource.OPERATOR


# Assisted choice


def test_assisted_switches_every_dwell_to_the_best(assisted: FakeShell) -> None:
    """The best robot is chosen at the start and anew after each 15 timesteps, not before."""
    start = switches(assisted.events)[-1]
    assert start.cause == "start"
    other = (start.to_robot + 1) % 5
    scores = [1.0 if robot == other else 0.0 for robot in range(5)]
    rows = [only_row(assisted.step(answering(scores=scores))) for _ in range(31)]
    assert [row.operated for row in rows] == [start.to_robot] * 15 + [other] * 16
    assert {row.choice_source for row in rows} == {ChoiceSource.SCORER}
    causes = [(s.cause, s.timestep) for s in switches(assisted.events)]
    assert causes == [("start", 0), ("dwell", 15)]


def test_assisted_rechooses_at_once_when_the_operated_robot_ends(assisted: FakeShell) -> None:
    """The next timestep already has another robot, and a whole dwell follows."""
    operated = switches(assisted.events)[-1].to_robot
    outcomes = [Outcome.GOAL if robot == operated else 0 for robot in range(5)]
    scores = [9.0 if robot == operated else float(-robot) for robot in range(5)]
    assisted.step()
    events = assisted.step(answering(outcomes=outcomes, scores=scores))
    (switch,) = switches(events)
    best = 0 if operated != 0 else 1
    assert (switch.cause, switch.to_robot, switch.timestep) == ("ended", best, 2)
    scores[best], scores[4 if best != 4 else 3] = -99.0, 99.0
    rows = [only_row(assisted.step(answering(scores=scores))) for _ in range(16)]
    assert [row.operated for row in rows[:15]] == [best] * 15
    assert rows[15].operated != best


def test_key_held_across_an_automatic_switch_does_not_act(assisted: FakeShell) -> None:
    """The new robot stands still until a key is pressed again."""
    operated = switches(assisted.events)[-1].to_robot
    scores = [1.0 if robot == (operated + 1) % 5 else 0.0 for robot in range(5)]
    assisted.key("up")
    rows = [only_row(assisted.step(answering(scores=scores))) for _ in range(17)]
    sources = [source(row, row.operated) for row in rows]
    assert sources == [ActionSource.OPERATOR] * 15 + [ActionSource.OPERATOR_IDLE] * 2
    assisted.key("up", down=False)
    assisted.key("up")
    row = only_row(assisted.step(answering(scores=scores)))
    assert source(row, row.operated) == ActionSource.OPERATOR


def test_assisted_operator_cannot_choose(assisted: FakeShell) -> None:
    """Number keys, Tab and clicks change nothing."""
    before = len(switches(assisted.events))
    for key in ("1", "2", "3", "tab"):
        assisted.tap(key)
    assisted.point("robot:1")
    assert len(switches(assisted.events)) == before


def test_assisted_without_a_scorer_goes_on(assisted: FakeShell) -> None:
    """Where the scorer's fit failed the block runs, the lowest running robot is operated."""
    loaded = short_study(*LONG)
    moods = Moods(end_chance=0.0, fits=("completed", "completed", "failed"))
    shell = FakeShell(opened(loaded, order=("assisted", "manual")), moods=moods)
    shell.go_to_trial(3, "assisted")
    row = only_row(shell.step())
    assert row.operated == 0
    assert row.scores.size == 0


def test_screen_shows_the_operated_robot_only(assisted: FakeShell, manual: FakeShell) -> None:
    """The assisted view holds one tile, the manual one all of them; neither shows a reward."""
    screen = assisted.fleet_screen()
    assert [tile.robot for tile in screen.tiles] == [screen.operated]
    assert len(manual.fleet_screen().tiles) == 3


# Correction


def test_correction_overrides_the_policy_only_while_a_key_acts(correcting: FakeShell) -> None:
    """With a key the robot does as told; without one it follows its policy."""
    correcting.step(answering(policy_actions=[1]))
    left = only_row(correcting.step(answering(policy_actions=[1])))
    assert (left.actions[0], source(left, 0)) == (1, ActionSource.POLICY)
    correcting.tap("up")
    told = only_row(correcting.step(answering(policy_actions=[1])))
    assert told.actions[0] == short_study().description.key_actions["up"]
    assert source(told, 0) == ActionSource.OPERATOR
    again = only_row(correcting.step())
    assert (again.actions[0], source(again, 0)) == (1, ActionSource.POLICY)
    assert again.choice_flag == ChoiceFlag.NO_CHOICE


# Time


def test_due_timestep_without_an_answer_is_skipped(manual: FakeShell) -> None:
    """While the fleet has not answered, what is due is skipped and recorded, never queued."""
    manual.due()
    (skipped,) = manual.due()
    assert isinstance(skipped, TimestepSkipped)
    assert only_row(manual.answer_fleet()).timestep == skipped.timestep
    assert manual.fleet is None


def test_stale_answer_is_nobodys(manual: FakeShell) -> None:
    """An answer to another request changes nothing."""
    manual.due()
    request = manual.fleet
    assert isinstance(request, StepFleet)
    assert manual.feed(manual.made_up(request, request_id=request.request_id - 1)) == ()
    assert only_row(manual.answer_fleet()).timestep == 0
