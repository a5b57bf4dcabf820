"""A wrong protocol file gets one message a problem; every shipped one is right."""

from __future__ import annotations

from pathlib import Path

import pytest

from protocols import variant
from study.errors import ProtocolError
from study.loading import load_protocol
from study.protocol import parse_protocol
from study.session.plan import TrialPlan
from study.session.sequence import stage_plans

ROBOT_KEYS = 'robots = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "-", "="]'
THIRD = '[[conditions]]\nname = "third"\nlabel = "Third"\nallocation = "manual"\nview = "tiles"\n'
THIRD += "robots = 12\n\n[phase_four]"
ASSUMED = '"timing.timesteps_per_second" ='

# Each: what is changed, and what each line of the message must hold.
WRONG: dict[str, tuple[list[tuple[str, str]], list[list[str]]]] = {
    "misspelt key": (
        [("episodes = 2", "episode = 2")],
        [["phase_one.episode:", "unknown key", 'did you mean "episodes"?', "refit"]],
    ),
    "key that is like no other": (
        [("episodes = 2", "episodes = 2\nnonsense = 1")],
        [["phase_one.nonsense: unknown key; allowed here:"]],
    ),
    "table that is like no other": (
        [("[timing]", "[nonsense]\nlevel = 1\n[timing]")],
        [["nonsense: unknown key; allowed here: "]],
    ),
    "misspelt table": (
        [("[timing]", "[timming]")],
        [["timming:", "unknown key", 'did you mean "timing"?']],
    ),
    "missing key": ([("episodes = 2\n", "")], [["phase_one.episodes:", "missing"]]),
    "missing format": ([("format = 1\n", "")], [["format: missing; write format = 1"]]),
    "empty text": (
        [('title = "Smoke test: every stage, shortened"', 'title = ""')],
        [["study.title:", "allowed: 1 character or more"]],
    ),
    "empty list": (
        [('when = ["before_reveal", "after_reveal"]', "when = []")],
        [["questionnaires.ease_and_success.when:", "allowed: 1 entry or more"]],
    ),
    "word for a number": (
        [("episodes = 2", 'episodes = "many"')],
        [["phase_one.episodes:", '"many" given', "a whole number"]],
    ),
    "text of a number": ([("episodes = 2", 'episodes = "2"')], [['"2" given', "a whole number"]]),
    "true for a number": (
        [("episodes = 2", "episodes = true")],
        [["true given", "a whole number"]],
    ),
    "too small": (
        [("episodes = 2", "episodes = 0")],
        [["phase_one.episodes:", "0 given", "allowed: 1 or more"]],
    ),
    "too large": (
        [("timesteps_per_second = 10.0", "timesteps_per_second = 1000")],
        [["timing.timesteps_per_second:", "1000", "allowed: 100 or less"]],
    ),
    "not a number": (
        [("at_least = 2", "at_least = nan")],
        [["exclusions.incomplete.at_least:", "finite"]],
    ),
    "other format": ([("format = 1", "format = 2")], [["format:", "2 given", "allowed: 1"]]),
    "unknown order": (
        [('order = "ab_ba"', 'order = "abba"')],
        [["phase_three.order:", '"abba" given', "latin_square", 'did you mean "ab_ba"?']],
    ),
    "unknown task": (
        [('name = "navigation"', 'name = "navigaton"')],
        [["task.name:", '"navigaton"', 'did you mean "navigation"?', "erratic"]],
    ),
    "unknown policy": (
        [('name = "nearest_neighbor"', 'name = "nearest_neighbour"')],
        [["policy.name:", 'did you mean "nearest_neighbor"?']],
    ),
    "policy that cannot learn": (
        [
            ('name = "nearest_neighbor"', 'name = "uniform_random"'),
            ('encoding = "sine_cosine"', ""),
        ],
        [["policy.name:", "uniform_random", "learns nothing", "nearest_neighbor"]],
    ),
    "unknown scorer": (
        [('[scorers.luce]\nname = "luce"', '[scorers.luce]\nname = "luse"')],
        [["scorers.luce.name:", '"luse"', 'did you mean "luce"?', "classifier"]],
    ),
    "scorer of no table": (
        [('scorer = "luce"', 'scorer = "luze"')],
        [["conditions.assisted.scorer:", '"luze"', 'did you mean "luce"?']],
    ),
    "unknown questionnaire": (
        [('name = "ease_and_success"', 'name = "ease_and_sucess"')],
        [["questionnaires.1.name:", 'did you mean "ease_and_success"?']],
    ),
    "unknown layout": (
        [('layout = "three_rooms"', 'layout = "three_room"')],
        [["task.parameters.layout:", '"three_room"', 'did you mean "three_rooms"?']],
    ),
    "task parameter": (
        [("horizon = 20", "horizon = 0")],
        [["task.parameters.horizon:", "0 given"]],
    ),
    "misspelt parameter": (
        [("horizon = 20", "horizons = 20")],
        [["task.parameters.horizons:", 'did you mean "horizon"?']],
    ),
    "policy parameter": (
        [('encoding = "sine_cosine"', 'encoding = "sine"')],
        [["policy.parameters.encoding:", '"sine" given', "sine_cosine"]],
    ),
    "not TOML": ([("[timing]", "[timing")], [["not TOML", "line 10"]]),
    "two problems at once": (
        [("episodes = 2", "episode = 2"), ("trial_timesteps = 30", "trial_timesteps = -3")],
        [["phase_one.episode:"], ["phase_two.trial_timesteps:", "-3 given"]],
    ),
    "two that do not go together": (
        [('name = "assisted"', 'name = "manual"'), ('scorer = "luce"', 'scorer = "x"')],
        [["conditions:", '"manual" is given twice'], ["conditions.manual.scorer:", '"x"']],
    ),
    "two unknown members": (
        [('name = "navigation"', 'name = "n"'), ('name = "nearest_neighbor"', 'name = "p"')],
        [["task.name:"], ["policy.name:"]],
    ),
    "assumption of nothing": (
        [(ASSUMED, '"timing.per_second" =')],
        [["assumptions:", '"timing.per_second" names no setting']],
    ),
    "assumption of nothing in a table that is wrong": (
        [(ASSUMED, '"timing.per_second" ='), ("timesteps_per_second = 10.0", "countdown = 1")],
        [
            ["timing.timesteps_per_second:", "missing"],
            ["timing.countdown:"],
            ["assumptions:", '"timing.per_second" names no setting'],
        ],
    ),
    "assumption without words, and another of nothing": (
        [(ASSUMED, '"study.name" = 3\n"study.nam" =')],
        [["assumptions.study.name:", "3 given"], ["assumptions:", '"study.nam"']],
    ),
    "assumption of what is yet to be mended": (
        [
            ("\ntrials = 2\n", "\ntrial = 2\n"),
            ('name = "manual"', 'name = "By hand"'),
            (ASSUMED, '"phase_two.trials" = "a"\n"conditions.manual.view" ='),
        ],
        [["phase_two.trial:", "unknown key"], ["conditions.1.name:", '"By hand"']],
    ),
    "assumption of no condition": (
        [(ASSUMED, '"conditions.other.view" =')],
        [["assumptions:", '"conditions.other.view"']],
    ),
    "key bound twice": (
        [('back = "backspace"', 'back = "return"')],
        [["keys:", "bound twice: return"]],
    ),
    "key that no keyboard has": (
        [('up = "up"', 'up = "flurb"')],
        [["keys.up:", '"flurb" given', "allowed: up, down,", "a to z, 0 to 9"]],
    ),
    "keys of other names": (
        [('confirm = "return"', 'confirm = "Enter"'), ('robots = ["1"', 'robots = ["one"')],
        [["keys.confirm:", 'did you mean "return"?'], ["keys.robots.1:", '"one" given']],
    ),
    "key that stops robots": (
        [('pause = "escape"', 'pause = "f12"')],
        [["keys.pause:", '"f12" given', "F12 stops real robots"]],
    ),
    "mistakes of every kind at once": (
        [
            ("horizon = 20", 'horizon = "x"'),
            ('scorer = "luce"', 'scorer = "lucy"'),
            ('up = "up"', 'up = "flurb"'),
            ('name = "ease_and_success"', 'name = "ease"'),
            ("episodes = 2", "episode = 2"),
        ],
        [
            ["phase_one.episode:", "unknown key"],
            ["conditions.assisted.scorer:", '"lucy"', 'did you mean "luce"?'],
            ["keys.up:", '"flurb" given'],
            ["task.parameters.horizon:", '"x" given', "allowed: a whole number"],
            ["questionnaires.1.name:", '"ease"'],
        ],
    ),
    "two mistakes in one condition": (
        [("dwell = 15", 'dwell = "x"'), ('scorer = "luce"', 'scorer = "lucy"')],
        [["conditions.assisted.dwell:"], ["conditions.assisted.scorer:", '"lucy"']],
    ),
    "misspelt table and a scorer of none": (
        [("[timing]", "[timming]"), ('scorer = "luce"', 'scorer = "lucy"')],
        [["timming:", "unknown key"], ["conditions.assisted.scorer:", '"lucy"']],
    ),
    "robot key bound twice": (
        [('next_robot = "tab"', 'next_robot = "3"')],
        [["keys:", "bound twice: 3"]],
    ),
    "too few robot keys": (
        [(ROBOT_KEYS, 'robots = ["1", "2", "3", "4"]')],
        [["keys.robots:", "4 keys", "fleet of 12"]],
    ),
    "ab_ba with three": (
        [("[phase_four]", THIRD)],
        [["phase_three.order:", '"ab_ba" needs two conditions, 3 given', "latin_square"]],
    ),
    "assisted without scorer": (
        [('scorer = "luce"\n', "")],
        [["conditions.assisted:", "an assisted condition needs a scorer"]],
    ),
    "assisted without dwell": ([("dwell = 15\n", "")], [["conditions.assisted:", "dwell"]]),
    "manual that hides": (
        [('view = "tiles"', 'view = "operated_only"')],
        [["conditions.manual:", "manual", 'view = "tiles"']],
    ),
    "name with blanks": (
        [('name = "manual"', 'name = "By hand"')],
        [["conditions.1.name:", '"By hand" given', "lower-case"]],
    ),
    "questionnaire twice": (
        [
            (
                "[keys]",
                '[[questionnaires]]\nname = "ease_and_success"\nwhen = ["before_reveal"]\n[keys]',
            )
        ],
        [["questionnaires:", '"ease_and_success" is listed twice']],
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_protocol_gets_one_message_a_problem(tmp_path: Path, case: str) -> None:
    """Each problem is one line: key path, what was given, what is allowed, the nearest name."""
    changes, expected = WRONG[case]
    path = variant(tmp_path, *changes)
    with pytest.raises(ProtocolError) as caught:
        load_protocol(str(path))
    problems = caught.value.problems
    assert len(problems) == len(expected), problems
    assert str(path) in str(caught.value)
    for problem, words in zip(problems, expected, strict=True):
        assert "\n" not in problem
        assert [word for word in words if word not in problem] == [], problem


@pytest.mark.parametrize(
    "path", ["study", "conditions.assisted.view", "scorers.luce.parameters", "keys.robots"]
)
def test_assumptions_may_name_any_setting(tmp_path: Path, path: str) -> None:
    """Tables, lists and named conditions are settings too."""
    loaded = load_protocol(str(variant(tmp_path, (ASSUMED, f'"{path}" ='))))
    assert list(loaded.protocol.assumptions) == [path]


@pytest.mark.parametrize("name", ["scaled_autonomy", "pilot", "smoke"])
def test_shipped_protocols_are_valid(name: str) -> None:
    """Each can be named, is valid, and every assumption says why."""
    loaded = load_protocol(name)
    assert loaded.protocol.study.name == name
    assert all(len(why) > 10 for why in loaded.protocol.assumptions.values())
    assert loaded.questionnaires.keys() == {use.name for use in loaded.protocol.questionnaires}


def test_smoke_is_under_a_minute() -> None:
    """Smoke's timesteps and longest episodes take less than 60 s."""
    loaded = load_protocol("smoke")
    rate = loaded.protocol.timing.timesteps_per_second
    plans = stage_plans(loaded.protocol, ("manual", "assisted"))
    timesteps = sum(
        loaded.description.horizon if plan.ends_with_robot else plan.timesteps
        for plan in plans
        if isinstance(plan, TrialPlan) and plan.allocation != "none"
    )
    assert timesteps / rate < 60


def test_paper_numbers_stand_in_its_protocol() -> None:
    """Every number that the paper gives is in scaled_autonomy.toml, unmarked."""
    protocol = load_protocol("scaled_autonomy").protocol
    assert protocol.phase_one.episodes == 10
    assert protocol.phase_one.initial_policy == "uniform_random"
    assert protocol.phase_two.robots == 4
    assert protocol.phase_three.trials == 8
    assert protocol.phase_three.order == "ab_ba"
    assert {condition.robots for condition in protocol.conditions} == {12}
    assert [condition.dwell for condition in protocol.conditions] == [0, 15]
    assert protocol.scorers["luce"].parameters["hidden"] == [32, 32]
    assert protocol.study.planned_participants == 12
    given = {"phase_one.episodes", "phase_two.robots", "phase_three.trials"}
    assert not given & protocol.assumptions.keys()
    assert {
        "timing.timesteps_per_second",
        "conditions.assisted.view",
    } <= protocol.assumptions.keys()


def test_condition_by_name() -> None:
    """A condition is found by its name."""
    protocol = load_protocol("smoke").protocol
    assert protocol.condition("assisted").scorer == "luce"


def test_parsing_needs_no_file() -> None:
    """A recorded protocol is read from its text alone."""
    text = load_protocol("pilot").text
    assert parse_protocol(text, "recorded") == load_protocol("pilot").protocol
