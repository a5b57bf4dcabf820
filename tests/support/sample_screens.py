"""Screens with representative values, for the tests of drawing and for pictures."""

from __future__ import annotations

import dataclasses
from typing import Literal

from study.events.scene import Scene
from study.events.task_description import RewardTerm
from study.layouts import named_layout
from study.screens import (
    BreakScreen,
    ConsentScreen,
    CountdownScreen,
    Cue,
    CueKind,
    EndScreen,
    FleetScreen,
    KeyTrialScreen,
    PageScreen,
    PauseScreen,
    RevealScreen,
    Screen,
    SurveyItem,
    SurveyScreen,
    Tile,
    WaitScreen,
)

SCENE: Scene = named_layout("three_rooms").scene()
FULL_SCENE: Scene = dataclasses.replace(SCENE, plate=None)
T_NS = 20_000_000_000
STEP = 0.125

DRIVE = ("left up down right", "drive")
PAUSE = ("escape", "pause")
CHOOSE = (DRIVE, ("1 … =", "choose"), ("tab", "next"), PAUSE)
ROBOT_KEYS = ("1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "-", "=")

POSES = (
    (6.6, 5.9, 0.0, 85.0), (13.5, 4.4, -0.4, 45.0), (17.7, 5.8, 1.57, 90.0),
    (17.1, 9.5, 2.1, 70.0), (10.9, 3.6, -2.5, 60.0), (16.2, 1.2, 0.1, 25.0),
    (17.8, 12.9, 2.2, 80.0), (11.9, 8.5, 3.3, 95.0), (8.2, 1.3, -0.1, 55.0),
    (2.3, 3.7, 1.0, 100.0), (1.6, 1.4, 0.6, 100.0), (14.3, 8.4, 3.14, 40.0),
)  # fmt: skip
CUES: dict[int, tuple[CueKind, float]] = {
    1: ("damage", 5.0), 5: ("low", 0.0), 6: ("pack", 10.0), 8: ("stuck", 6.0),
    9: ("lost", 0.0), 10: ("goal", 0.0),
}  # fmt: skip


def tiles(robots: int, *, cued: bool = True) -> tuple[Tile, ...]:
    """Return robots spread over the map, some with cues."""
    made = []
    for robot in range(robots):
        x, y, heading, health = POSES[robot % len(POSES)]
        cue = CUES.get(robot % 17) if cued else None
        made.append(
            Tile(
                robot=robot,
                x=x,
                y=y,
                heading=heading,
                health=health,
                cue=Cue(cue[0], cue[1], T_NS) if cue else None,
                episode=1,
            )
        )
    return tuple(made)


def fleet(robots: int = 12, *, operated: int = 4, cued: bool = True) -> FleetScreen:
    """Return a manual fleet run."""
    return FleetScreen(
        heading="Part 3 of 4, block 1 of 2",
        trial=3,
        trials=8,
        seconds_left=41.6,
        seconds_total=60.0,
        scene=SCENE,
        tiles=tiles(robots, cued=cued),
        robots=robots,
        operated=operated,
        allocation="manual",
        view="tiles",
        suggested=-1,
        dwell_left=-1.0,
        switched_ns=-1,
        timestep=147,
        t_ns=T_NS,
        timestep_seconds=STEP,
        keys=CHOOSE,
        message="",
        robot_keys=ROBOT_KEYS,
    )


def moved(screen: FleetScreen) -> FleetScreen:
    """Return the states one timestep before a screen's, so that robots have a trail."""
    before = tuple(
        dataclasses.replace(tile, x=tile.x - 0.4, heading=tile.heading - 0.1)
        for tile in screen.tiles
    )
    return dataclasses.replace(
        screen,
        tiles=before,
        timestep=screen.timestep - 1,
        t_ns=screen.t_ns - round(STEP * 1e9),
    )


def assisted(*, operated: int = 6, cue: Cue | None = None) -> FleetScreen:
    """Return an assisted run of which only the operated robot is seen."""
    tile = dataclasses.replace(tiles(12)[operated], x=11.0, y=4.8, heading=-0.7, cue=cue)
    return dataclasses.replace(
        fleet(12, operated=operated),
        heading="Part 3 of 4, block 2 of 2",
        tiles=(tile,),
        allocation="assisted",
        view="operated_only",
        dwell_left=0.62,
        switched_ns=T_NS - 100_000_000,
        keys=(DRIVE, PAUSE),
    )


def correction() -> FleetScreen:
    """Return one robot that the participant corrects."""
    return dataclasses.replace(
        fleet(1, operated=0),
        heading="Part 1 of 4",
        trial=4,
        trials=10,
        allocation="correction",
        keys=(DRIVE, PAUSE),
        message="Correct the robot whenever it goes wrong",
    )


def page(figure: str) -> PageScreen:
    """Return a page with an illustration."""
    titles = {
        "": ("Teach one robot", "10 runs with one robot. It learns from what you do."),
        "map": (
            "Bring the robots to their goal",
            "You drive one robot at a time. The others drive themselves, not always well.",
        ),
        "choose": (
            "12 robots: you choose",
            "8 trials. You choose which robot to drive, as before.",
        ),
        "assisted": (
            "12 robots: you are switched",
            "8 trials. Which robot you drive is chosen for you.",
        ),
    }
    texts = {
        "": (
            "The robot drives by itself. At first it has no idea and moves at random.",
            "Whenever it goes wrong, hold an arrow key: then it does what you say. "
            "Let go, and it drives itself again.",
            "After each run it has learned from your corrections. A run ends at the goal, "
            "when the robot's health is used up, or when its time is up.",
        ),
        "map": (),
        "choose": (
            "Take over the robot that you can help most, and change whenever you like.",
            "Your points are shown when the block is finished.",
        ),
        "assisted": (
            "Every moment or so it is chosen anew which robot you drive. "
            "A ring shows how long is left until the next switch.",
            "You see only the robot that you drive; the others drive on unseen.",
            "After a switch, press the arrow key again. "
            "Your points are shown when the block is finished.",
        ),
    }
    return PageScreen(
        header_left="How it works",
        header_right="Page 2 of 4",
        title=titles[figure][0],
        subtitle=titles[figure][1],
        paragraphs=texts[figure],
        figure=figure,
        scene=SCENE,
        rewards=REWARDS if figure == "map" else (),
        timesteps_per_second=8.0,
        robots=12,
        can_go_back=True,
        next_hint="Next: a short drive to try it out",
        action="to go on",
        robot_keys=ROBOT_KEYS,
    )


REWARDS = (
    RewardTerm("progress", 1.0, "each metre", "closer to the goal"),
    RewardTerm("goal", 10.0, "robot reaches", "the goal"),
    RewardTerm("health", 0.1, "each health point", "gained or lost"),
    RewardTerm("lost", -10.0, "robot lost", "(health 0)"),
    RewardTerm("timestep", -0.05, "each step", "(8 a second)"),
)


def survey(*, values: tuple[int | None, ...] = (5, None), focus: int = 0) -> SurveyScreen:
    """Return the two questions."""
    texts = (
        "It was easy to guide the robots to their goals.",
        "I was successful at guiding the robots.",
        "I felt in control of the fleet.",
    )
    labels = (
        (1, "Strongly disagree"),
        (4, "Neither disagree nor agree"),
        (7, "Strongly agree"),
    )
    items = tuple(
        SurveyItem(item=f"q{i + 1}", text=texts[i], low=1, high=7, labels=labels, value=value)
        for i, value in enumerate(values)
    )
    return SurveyScreen(
        header_left="Part 3 of 4, block 1 of 2: finished",
        header_right="Questions 1 and 2 of 2",
        title="About the block you just finished",
        prompt="How much do you agree with each sentence?",
        items=items,
        focus=focus,
        complete=all(value is not None for value in values),
        reminder="",
    )


def form(*items: SurveyItem, focus: int = 0) -> SurveyScreen:
    """Return a form of other kinds of questions."""
    return dataclasses.replace(
        survey(), header_left="Before we start", header_right="Questions 1 to 3 of 6",
        title="About you", prompt="A few questions before we start.", items=items, focus=focus,
        complete=False,
    )  # fmt: skip


def about_you() -> SurveyScreen:
    """Return a number, a choice that is made and a text."""
    often = ("Never", "A few times a year", "Monthly", "Weekly", "Daily")
    return form(
        SurveyItem("age", "How old are you?", 16, 110, (), None, kind="number", typed="1"),
        SurveyItem("games", "How often do you play?", 1, 5, (), 2, kind="choice", options=often),
        SurveyItem("words", "Anything else?", 0, 400, (), 4, kind="text", typed="1 2 3"),
    )


def load_index() -> SurveyScreen:
    """Return long scales in steps of five."""
    ends = ((0, "Very low"), (100, "Very high"))
    asked = (
        ("mental", "Mental demand: how mentally demanding was the task?", None),
        ("physical", "Physical demand: how physically demanding was the task?", 100),
        ("success", "Performance: how successful were you in what you were asked to do?", 35),
    )
    return form(*(SurveyItem(name, text, 0, 100, ends, value, step=5)
                  for name, text, value in asked))  # fmt: skip


def consent(chosen: Literal["", "agreed", "declined"] = "") -> ConsentScreen:
    """Return a text to agree to, as long as such texts are."""
    return ConsentScreen(
        "Before we start",
        (
            "You are invited to take part in a study on how people look after a fleet of robots. "
            "It takes about an hour.",
            "Your keys, your answers and the robots' paths are recorded under a pseudonym. They "
            "may be published in that form. Nothing else about you is kept.",
            "You can pause and stop at any time, without giving a reason, and have everything "
            "erased that was recorded.",
            "There are no known risks beyond those of an hour before a screen.",
        ),
        chosen,
    )


def reveal(*, negative: bool = False) -> RevealScreen:
    """Return a block's points."""
    rewards = (148.2, 171.0, 96.4, 204.0, 187.3, 162.0, 221.4, 195.1)
    if negative:
        rewards = (-48.2, 12.0, -96.4, 3.1, 87.3, -1.0, 121.4, 195.1)
    return RevealScreen(
        header_left="Part 3 of 4, block 1 of 2: finished",
        header_right="Your points",
        block=1,
        total=sum(rewards),
        trial_rewards=rewards,
        robots=12,
        scale_low=-100.0 if negative else 0.0,
        scale_high=300.0,
        next_hint="Next: the same two questions again. Your first answers stay as they are.",
    )


def ready() -> PageScreen:
    """Return the page before a trial."""
    return dataclasses.replace(
        page(""),
        header_left="Part 3 of 4, block 1 of 2",
        header_right="",
        title="Trial 3 of 8",
        subtitle="12 robots, 60 seconds. Begin when you are ready.",
        paragraphs=(),
        scene=None,
        can_go_back=False,
        next_hint="",
        action="to start",
    )


def samples() -> dict[str, Screen]:
    """Return one screen of every kind and situation, by name."""
    manual = fleet(12)
    suggested = dataclasses.replace(
        manual,
        allocation="suggested",
        suggested=7,
        operated=2,
        keys=(DRIVE, ("Space", "accept"), *CHOOSE[1:3]),
    )
    return {
        "fleet_12": manual,
        "fleet_12_none_chosen": dataclasses.replace(
            manual, operated=-1, message="Choose a robot to drive"
        ),
        "fleet_12_suggested": suggested,
        "fleet_12_assisted_tiles": dataclasses.replace(
            manual, allocation="assisted", dwell_left=0.4, switched_ns=T_NS - 150_000_000
        ),
        "fleet_2": fleet(2, operated=1),
        "fleet_4": fleet(4, operated=1),
        "fleet_48": dataclasses.replace(fleet(48, operated=21), keys=(DRIVE, *CHOOSE[2:])),
        "fleet_12_full_scene": dataclasses.replace(manual, scene=FULL_SCENE),
        "assisted_landing": assisted(),
        "assisted_cue": dataclasses.replace(assisted(cue=Cue("stuck", 7.0, T_NS)), switched_ns=-1),
        "assisted_full_scene": dataclasses.replace(
            assisted(cue=Cue("damage", 5.0, T_NS)), scene=FULL_SCENE
        ),
        "assisted_nobody": dataclasses.replace(assisted(), tiles=(), operated=-1),
        "correction": correction(),
        "watching": dataclasses.replace(
            correction(), allocation="none", operated=-1, message="", keys=(PAUSE,)
        ),
        "page_text": page(""),
        "page_ready": ready(),
        "page_map": page("map"),
        "page_map_text": dataclasses.replace(
            page("map"), paragraphs=("Robots that reach the goal start again somewhere else.",)
        ),
        "page_choose": page("choose"),
        "page_assisted": page("assisted"),
        "page_assisted_all": dataclasses.replace(page("assisted"), figure="assisted_all"),
        "survey_one_answered": survey(),
        "survey_open": dataclasses.replace(
            survey(values=(None, None)), reminder="Please answer this question first."
        ),
        "survey_complete": survey(values=(5, 4), focus=2),
        "survey_three": survey(values=(5, None, None), focus=1),
        "reveal": reveal(),
        "reveal_negative": reveal(negative=True),
        "wait": WaitScreen(
            "The robots drive on their own now",
            "Trying out set 1 of what you taught them. There is nothing to do for you.",
            0.4,
        ),
        "wait_unknown": WaitScreen("One moment", "The robot is learning from your drive.", -1.0),
        "assisted_announced": dataclasses.replace(
            assisted(), switched_ns=-1, dwell_left=0.1, switch_seconds_left=0.4
        ),
        "tiles_announced": dataclasses.replace(
            manual, allocation="assisted", dwell_left=0.1, switch_seconds_left=0.4
        ),
        "countdown": CountdownScreen(3, dataclasses.replace(manual, switched_ns=-1)),
        "countdown_enlarged": CountdownScreen(
            3, dataclasses.replace(manual, operated=-1, view="enlarged")
        ),
        "break_must": BreakScreen(seconds_left=95, seconds_total=120, wait_seconds=35),
        "break_may": BreakScreen(seconds_left=0, seconds_total=120, wait_seconds=0),
        "consent": consent(),
        "consent_agreed": consent("agreed"),
        "survey_kinds": about_you(),
        "survey_long_scales": load_index(),
        "pause_erase": PauseScreen("", confirm_stop=False, can_erase=True),
        "pause_erase_sure": PauseScreen("", confirm_stop=False, can_erase=True, confirm_erase=True),
        "pause": PauseScreen("Paused", confirm_stop=False),
        "pause_stop": PauseScreen("Paused", confirm_stop=True),
        "pause_held": PauseScreen(
            "The experimenter has paused the session",
            confirm_stop=False,
            can_erase=True,
            can_go_on=False,
        ),
        "pause_held_stop": PauseScreen(
            "The experimenter has paused the session",
            confirm_stop=True,
            can_erase=True,
            can_go_on=False,
        ),
        "key_trial": KeyTrialScreen((("up", True), ("left", False)), 10.0),
        "end": EndScreen(
            "Thank you!", "That was all. Please tell the experimenter that you have finished."
        ),
        "end_early": EndScreen(
            "Thank you for your time.",
            "You do not take part, and nothing was recorded. Please tell the experimenter.",
            achieved=False,
        ),
    }
