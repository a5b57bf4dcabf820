"""What is shown, as plain values. The window draws them; simulated operators read them.

A simulated operator sees nothing that is not on the screen, so what a screen of a
hidden robot would show is not in the value.
"""

from __future__ import annotations

import dataclasses
from typing import Literal

from study.events.scene import Scene
from study.events.task_description import RewardTerm

View = Literal["tiles", "operated_only", "enlarged"]
"""All robots as tiles; the operated one alone; the operated one enlarged beside the tiles."""
CueKind = Literal["held", "lost", "time_up", "goal", "damage", "stuck", "low", "pack"]
"""What happened; "held" is a robot that was stopped by what watches over it, and waits."""


@dataclasses.dataclass(frozen=True, slots=True)
class Cue:
    """A short message in a tile.

    Attributes:
        kind: what happened; the window picks colour, mark and text.
        amount: health points for damage and pack; seconds for stuck; else 0.
        since_ns: session time at which it began.
    """

    kind: CueKind
    amount: float
    since_ns: int


@dataclasses.dataclass(frozen=True, slots=True)
class Tile:
    """One robot as shown.

    Attributes:
        robot: index from 0; the number on the tile is robot + 1.
        x, y: metres.
        heading: radians, counter-clockwise from +x.
        health: 0 to 100; 100 where the task has none, which is not shown.
        cue: the one cue shown, or None.
        episode: number of its episode; a new one must not be interpolated from the last.
    """

    robot: int
    x: float
    y: float
    heading: float
    health: float
    cue: Cue | None
    episode: int


@dataclasses.dataclass(frozen=True, slots=True)
class FleetScreen:
    """A fleet run in progress.

    Attributes:
        heading: "Part 2 of 4" or "Block 1 of 2".
        trial, trials: progress; trials 0 hides it (practice).
        unit: what is counted: "Trial", or "Episode" in phase one.
        seconds_left, seconds_total: time of the trial.
        scene: the map, the same in every tile.
        tiles: the robots that are visible: all of them, or the operated one only.
        robots: n, visible or not.
        operated: index from 0, -1 if none.
        allocation: "correction", "manual", "suggested", "assisted" or "none".
        view: "tiles", "operated_only" or "enlarged" (the operated robot large beside the tiles).
        suggested: index of the suggested robot, -1 if none.
        dwell_left: fraction of the dwell left, 1 to 0; -1 if there is none.
        switched_ns: session time of the last switch; -1 if none yet.
        timestep: number of the current timestep.
        t_ns: session time at which the states hold.
        timestep_seconds: time until the next states.
        keys: labels of the keys in use: drive, choose, pause ((label, word) pairs).
        message: one line of guidance, or empty ("Choose a robot").
        robot_keys: names of the keys that choose robots 1, 2, ...; empty if none do.
        switch_seconds_left: time until the scorer chooses anew, while that is announced; else -1.
        landing_seconds: how long after a switch its landing is marked.
        accept_key: name of the key that accepts a suggestion.
        has_health: whether the robots have health.
    """

    heading: str
    trial: int
    trials: int
    seconds_left: float
    seconds_total: float
    scene: Scene
    tiles: tuple[Tile, ...]
    robots: int
    operated: int
    allocation: str
    view: View
    suggested: int
    dwell_left: float
    switched_ns: int
    timestep: int
    t_ns: int
    timestep_seconds: float
    keys: tuple[tuple[str, str], ...]
    message: str
    unit: str = "Trial"
    robot_keys: tuple[str, ...] = ()
    switch_seconds_left: float = -1.0
    landing_seconds: float = 1.2
    accept_key: str = "space"
    has_health: bool = True


@dataclasses.dataclass(frozen=True, slots=True)
class CountdownScreen:
    """A trial is about to start.

    Attributes:
        seconds_left: whole seconds, at least 1.
        fleet: the robots as they will start, drawn behind.
    """

    seconds_left: int
    fleet: FleetScreen


@dataclasses.dataclass(frozen=True, slots=True)
class BreakScreen:
    """A rest.

    Attributes:
        seconds_left, seconds_total: of the suggested rest, s.
        wait_seconds: how long Enter does nothing yet; 0 when it goes on.
    """

    seconds_left: int
    seconds_total: int
    wait_seconds: int


@dataclasses.dataclass(frozen=True, slots=True)
class ConsentScreen:
    """The text that is agreed to; targets "agree", "decline" and "confirm".

    Attributes:
        title, paragraphs: the text.
        chosen: "agreed", "declined", or "" for nothing yet.
    """

    title: str
    paragraphs: tuple[str, ...]
    chosen: Literal["", "agreed", "declined"]


@dataclasses.dataclass(frozen=True, slots=True)
class PageScreen:
    """A page to read.

    Attributes:
        header_left, header_right: "How it works", "Page 2 of 4".
        title, subtitle: the headline and one sentence.
        paragraphs: body text.
        figure: which illustration, if any: "" | "map" (annotated map, keys, points) |
            "choose" (how to choose a robot) | "assisted" (how switching works) |
            "assisted_all" (the same where all robots are seen).
        scene: the map for the illustration.
        rewards: the points rules, shown with figure "map".
        timesteps_per_second: for "(8 a second)".
        robots: number named in the illustration.
        can_go_back: whether Backspace goes back.
        next_hint: what comes next, or empty.
        action: what Enter does: "to go on", "to start".
        robot_keys: names of the keys that choose robots 1, 2, ..., for figure "choose".
        has_health: whether the robots have health.
    """

    header_left: str
    header_right: str
    title: str
    subtitle: str
    paragraphs: tuple[str, ...]
    figure: str
    scene: Scene | None
    rewards: tuple[RewardTerm, ...]
    timesteps_per_second: float
    robots: int
    can_go_back: bool
    next_hint: str
    action: str
    robot_keys: tuple[str, ...] = ()
    has_health: bool = True


@dataclasses.dataclass(frozen=True, slots=True)
class SurveyItem:
    """One question.

    Attributes:
        item: its id, for example "q1".
        text: the sentence.
        low, high: smallest and largest answer; of a text its length in characters.
        labels: (value, words) pairs.
        value: the answer, or None; of a choice the number of the option, from 1.
        kind: "scale", "choice", "number" or "text".
        step: of a scale.
        options: of a choice.
        typed: the characters of a number or text so far.
    """

    item: str
    text: str
    low: int
    high: int
    labels: tuple[tuple[int, str], ...]
    value: int | None
    kind: Literal["scale", "choice", "number", "text"] = "scale"
    step: int = 1
    options: tuple[str, ...] = ()
    typed: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class SurveyScreen:
    """Questions, answered by digits, arrows, Tab, mouse; confirmed by Enter.

    Attributes:
        header_left, header_right: "Block 1 of 2: finished", "Questions 1 and 2 of 2".
        title, prompt: the headline and the instruction.
        items: the questions.
        focus: index of the question that digits answer; len(items) is the button.
        complete: whether Enter confirms.
        reminder: shown after Enter with a question open, else empty.
        first: number of the first question on this page.
    """

    header_left: str
    header_right: str
    title: str
    prompt: str
    items: tuple[SurveyItem, ...]
    focus: int
    complete: bool
    reminder: str
    first: int = 1

    @property
    def takes_text(self) -> bool:
        """Whether the question in focus is answered by typing words."""
        return self.focus < len(self.items) and self.items[self.focus].kind == "text"


@dataclasses.dataclass(frozen=True, slots=True)
class RevealScreen:
    """The block's reward.

    Attributes:
        header_left, header_right: "Block 1 of 2: finished", "Your points".
        block: number of the block.
        total: points of the block.
        trial_rewards: points of each trial.
        robots: n.
        scale_low, scale_high: ends of the axis, the same in every block; 0 lies within.
        next_hint: "Next: the same two questions again. ..."
    """

    header_left: str
    header_right: str
    block: int
    total: float
    trial_rewards: tuple[float, ...]
    robots: int
    scale_low: float
    scale_high: float
    next_hint: str


@dataclasses.dataclass(frozen=True, slots=True)
class WaitScreen:
    """Something is being computed.

    Attributes:
        title, text: what and why.
        progress: 0 to 1, or -1 if unknown.
    """

    title: str
    text: str
    progress: float


@dataclasses.dataclass(frozen=True, slots=True)
class PauseScreen:
    """The session stands still: Enter goes on, Q stops and keeps the recording, E erases it.

    Attributes:
        reason: the headline.
        confirm_stop: whether Y stops and keeps.
        can_erase: whether erasing is offered.
        confirm_erase: whether Y stops and erases.
        can_go_on: whether the participant may end the pause; else only the experimenter can.
    """

    reason: str
    confirm_stop: bool
    can_erase: bool = False
    confirm_erase: bool = False
    can_go_on: bool = True


@dataclasses.dataclass(frozen=True, slots=True)
class EndScreen:
    """The last screen; any of Enter and Escape closes it.

    Attributes:
        title, text: the last words.
        achieved: whether all was done that was to be done: it is marked by a tick.
    """

    title: str
    text: str
    achieved: bool = True


@dataclasses.dataclass(frozen=True, slots=True)
class KeyTrialScreen:
    """A preflight asks for keys that are held down together.

    Attributes:
        wanted: names of the keys, and whether each has arrived.
        seconds: how long it waits.
    """

    wanted: tuple[tuple[str, bool], ...]
    seconds: float


Screen = (
    FleetScreen
    | CountdownScreen
    | PageScreen
    | SurveyScreen
    | RevealScreen
    | BreakScreen
    | ConsentScreen
    | WaitScreen
    | PauseScreen
    | KeyTrialScreen
    | EndScreen
)
