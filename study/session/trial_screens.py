"""What a trial shows: the fleet as the condition's view allows, and its cues."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.events.codes import Phase
from study.events.inputs import FleetObserved
from study.events.task_description import TaskDescription
from study.screens import (
    CountdownScreen,
    Cue,
    FleetScreen,
    PageScreen,
    Screen,
    Tile,
    View,
    WaitScreen,
)
from study.session.actions import driving_keys
from study.session.allocation import (
    AnyAllocation,
    AssistedAllocation,
    ManualAllocation,
    SuggestedAllocation,
)
from study.session.context import Context
from study.session.cues import Cues
from study.session.fleet_run import FleetRun
from study.session.offers import OfferAllocation
from study.session.page_texts import block_heading, parts_of
from study.session.plan import TrialPlan
from study.session.robot_reports import held_message
from study.session.switching import SwitchWatch

_CHOSEN_BY_KEY = ("manual", "suggested", "correction_round")


def heading(plan: TrialPlan, context: Context) -> str:
    """Return the words at the top left: which part or block this is."""
    if plan.place.phase == Phase.PRACTICE:
        if plan.place.block:
            return context.say(
                "Practice for block {block} of {blocks}",
                block=plan.place.block, blocks=len(context.order),
            )  # fmt: skip
        return context.say("Practice")
    if plan.place.phase == Phase.THREE:
        return block_heading(context, plan.place.block)
    return context.say(
        "Part {part} of {parts}", part=int(plan.place.phase), parts=parts_of(context)
    )


def unit(plan: TrialPlan, context: Context) -> str:
    """Return the word for one run: an episode is one robot's, from reset to end."""
    return context.say("Episode") if plan.ends_with_robot else context.say("Trial")


def ready_screen(plan: TrialPlan, context: Context) -> PageScreen:
    """Return the screen that waits for the operator before a trial."""
    say = context.say
    title = say("Practice") if plan.attempt == 1 else say("Practice once more")
    if plan.scored:
        title = say(
            "{unit} {number} of {total}",
            unit=unit(plan, context), number=plan.trial, total=plan.trials,
        )  # fmt: skip
    return PageScreen(
        header_left=heading(plan, context),
        header_right="",
        title=title,
        subtitle=" ".join(_what_comes(plan, context)),
        paragraphs=(),
        figure="",
        scene=None,
        rewards=(),
        timesteps_per_second=context.protocol.timing.timesteps_per_second,
        robots=plan.robots,
        can_go_back=False,
        next_hint="",
        action=say("to start"),
    )


def first_screen(plan: TrialPlan, context: Context) -> Screen:
    """Return what is shown before a trial's fleet is there."""
    if plan.allocation == "none":
        return evaluation_screen(plan, context, 0)
    return ready_screen(plan, context)


def _what_comes(plan: TrialPlan, context: Context) -> list[str]:
    """Return sentences on the robots, the time and what is to be done."""
    say, count = context.say, context.count
    robots = say("One robot") if plan.robots == 1 else say("{n} robots", n=plan.robots)
    seconds = plan.timesteps / context.protocol.timing.timesteps_per_second
    first = say("{robots}.", robots=robots)
    if not plan.ends_with_robot and seconds < 1:
        first = say("{robots}, less than a second.", robots=robots)
    elif not plan.ends_with_robot:
        first = count(
            "{robots}, {n} second.", "{robots}, {n} seconds.", round(seconds), robots=robots
        )
    goals = plan.goals_needed
    task = (
        [count("Bring it to its goal once.", "Bring it to its goal {n} times.", goals)]
        if goals
        else []
    )
    return [first, *task, say("Begin when you are ready.")]


def evaluation_screen(plan: TrialPlan, context: Context, timestep: int) -> WaitScreen:
    """Return the screen of a trial in which nobody operates."""
    done = (plan.trial - 1 + timestep / plan.timesteps) / plan.trials
    return WaitScreen(
        title=context.say("The robots drive on their own now"),
        text=context.say(
            "They show what they learned from you, set {number}. There is nothing to do for you.",
            number=plan.place.block,
        ),
        progress=done,
    )


class TrialScreens:
    """Builds the fleet screen of a running trial."""

    def __init__(
        self,
        plan: TrialPlan,
        context: Context,
        run: FleetRun,
        allocation: AnyAllocation,
        watch: SwitchWatch,
    ) -> None:
        self._plan = plan
        self._context = context
        self._run = run
        self._allocation = allocation
        self._watch = watch
        self._countdown = 0
        self._description: TaskDescription = context.description
        self._cues = Cues(context.description, run.now.states)
        self._switched_ns = -1
        self._t_ns = 0
        self._timestep = 0
        self._heading = heading(plan, context)
        chosen_by_key = plan.robots > 1 and plan.allocation in _CHOSEN_BY_KEY
        keys = context.protocol.keys.robots
        # With more robots than keys, numbers are typed: they stand on the tiles.
        one_each = chosen_by_key and plan.robots <= len(keys)
        self._robot_keys = keys[: plan.robots] if one_each else ()

    def start(self, t_ns: int) -> None:
        """The trial begins to run."""
        self._t_ns = t_ns
        self._cues.start(t_ns)

    def resumed(self, t_ns: int) -> None:
        """A pause is over: what stood still for it is not stuck."""
        self._cues.start(t_ns)

    def switched(self, t_ns: int) -> None:
        """Another robot is operated."""
        self._switched_ns = t_ns

    def observe(
        self, before: FleetObserved, after: FleetObserved, restarted: npt.NDArray[np.bool_]
    ) -> None:
        """Take in one timestep."""
        if self._plan.allocation != "none":
            self._cues.observe(before.states, after.states, after.outcomes, restarted, after.t_ns)

    def worth_showing(self, timestep: int) -> bool:
        """Whether the picture changes enough: where nobody operates, at every tenth part."""
        return self._plan.allocation != "none" or timestep % max(1, self._plan.timesteps // 10) == 0

    def update(self, t_ns: int, timestep: int, countdown: int) -> None:
        """Set the time that the screen is for, and the seconds until the trial runs."""
        self._t_ns, self._timestep, self._countdown = t_ns, timestep, countdown

    def screen(self) -> Screen:
        """Return the screen as it is now."""
        plan = self._plan
        if plan.allocation == "none":
            return evaluation_screen(plan, self._context, self._timestep)
        fleet = self._fleet_screen()
        return CountdownScreen(self._countdown, fleet) if self._countdown else fleet

    def _fleet_screen(self) -> FleetScreen:
        plan = self._plan
        rate = self._context.protocol.timing.timesteps_per_second
        horizon, limit = self._description.horizon, plan.timesteps
        limit = min(horizon, limit) if plan.ends_with_robot else limit
        allocation = self._allocation
        operated = allocation.operated
        states = self._run.now.states.tolist()
        shown = _what_is_shown(plan, allocation)
        return FleetScreen(
            heading=self._heading,
            trial=plan.trial,
            trials=plan.trials if plan.scored else 0,
            seconds_left=max(0.0, (limit - self._timestep) / rate),
            seconds_total=limit / rate,
            scene=self._description.scene,
            tiles=tuple(self._tile(robot, states[robot]) for robot in shown.robots if robot >= 0),
            robots=plan.robots,
            operated=operated,
            allocation=shown.allocation,
            view=shown.view,
            suggested=allocation.suggested if isinstance(allocation, SuggestedAllocation) else -1,
            dwell_left=shown.dwell_left,
            switched_ns=self._switched_ns,
            timestep=self._timestep,
            t_ns=self._t_ns,
            timestep_seconds=1.0 / rate,
            keys=_key_legend(plan.robots, shown.allocation, self._context),
            message=self._message(),
            robot_keys=self._robot_keys if shown.allocation != "assisted" else (),
            unit=unit(plan, self._context),
            accept_key=self._context.protocol.keys.accept,
            has_health=self._description.health_field >= 0,
            switch_seconds_left=self._watch.seconds_left(allocation)
            if self._context.protocol.switching.cue_seconds > 0
            else -1.0,
            landing_seconds=self._context.protocol.switching.landing_seconds,
        )

    def _message(self) -> str:
        if held := held_message(self._context, self._plan.robots):
            return held
        allocation = self._allocation
        if isinstance(allocation, OfferAllocation) and allocation.operated < 0:
            return self._context.say("Choose one of these robots to drive")
        if isinstance(allocation, ManualAllocation) and allocation.operated < 0:
            return self._context.say("Choose a robot to drive")
        if self._plan.allocation == "correction":
            return self._context.say("Correct the robot whenever it goes wrong")
        return ""

    def _tile(self, robot: int, state: list[float]) -> Tile:
        description = self._description

        def field(place: int, default: float) -> float:
            return state[place] if place >= 0 else default

        health = field(description.health_field, 100.0)
        return Tile(
            robot=robot,
            x=field(description.x_field, description.scene.width / 2),
            y=field(description.y_field, description.scene.height / 2),
            heading=field(description.heading_field, 0.0),
            health=health,
            cue=Cue("held", 0.0, self._t_ns)
            if robot in self._context.knowledge.held_robots
            else self._cues.cue(robot, health, self._t_ns),
            episode=self._run.episodes[robot],
        )


@dataclasses.dataclass(frozen=True, slots=True)
class _Shown:
    """What of a fleet is on the screen.

    Attributes:
        allocation, view, dwell_left: see `study.screens.FleetScreen`.
        robots: indices; -1 is none.
    """

    allocation: str
    view: View
    dwell_left: float
    robots: tuple[int, ...]


def _what_is_shown(plan: TrialPlan, allocation: AnyAllocation) -> _Shown:
    """Return what is shown now: in a correction round the robot driven, or those offered."""
    operated = (allocation.operated,)
    everyone = tuple(range(plan.robots))
    if isinstance(allocation, OfferAllocation):
        if allocation.offering:
            return _Shown("manual", "tiles", -1.0, allocation.offered)
        return _Shown("assisted", "operated_only", allocation.part_left(), operated)
    dwell_left = allocation.dwell_left() if isinstance(allocation, AssistedAllocation) else -1.0
    robots = operated if plan.view == "operated_only" else everyone
    return _Shown(plan.allocation, plan.view, dwell_left, robots)


def _key_legend(robots: int, allocation: str, context: Context) -> tuple[tuple[str, str], ...]:
    """Return (key, word) pairs in the order of the header."""
    keys, say = context.protocol.keys, context.say
    legend = [(" ".join(driving_keys(keys, context.description)), say("drive"))]
    if robots > 1 and allocation == "suggested":
        legend.append((keys.accept, say("accept")))
    if robots > 1 and allocation in ("manual", "suggested"):
        chosen = keys.robots[:robots]
        last = chosen[-1] if robots <= len(keys.robots) else str(robots)
        legend += [(f"{chosen[0]} … {last}", say("choose")), (keys.next_robot, say("next"))]
    return (*legend, (keys.pause, say("pause")))
