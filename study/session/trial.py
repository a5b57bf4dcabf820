"""The trial stage: one fleet run, from the operator's readiness to its end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource, Outcome, Phase
from study.events.events import Suggestion, Switched, Timestep, TimestepSkipped, TrialEnded
from study.events.inputs import FleetObserved, Input, KeyChanged, PointerPressed, TimestepDue
from study.screens import Screen
from study.seeding import stream_seed
from study.session.actions import decide_actions, key_actions
from study.session.allocation import (
    AssistedAllocation,
    ManualAllocation,
    SuggestedAllocation,
)
from study.session.context import Context, Outbox
from study.session.controls import Controls
from study.session.effects import EnsureDurable, SetPace, Show, StartFleet, StepFleet, StopFleet
from study.session.fit_gate import trial_as_run
from study.session.fleet_run import FleetRun
from study.session.kept import KeptTimesteps
from study.session.number_entry import NumberEntry
from study.session.offers import OfferAllocation, trial_allocation
from study.session.plan import UNIFORM_RANDOM, TrialPlan
from study.session.practice import judge_practice
from study.session.switching import SwitchWatch
from study.session.trial_events import episode_ended, trial_started
from study.session.trial_screens import TrialScreens, first_screen


class TrialStage:
    """Ready screen, start of the fleet, timesteps, end."""

    kind = "trial"

    def __init__(self, plan: TrialPlan, context: Context) -> None:
        plan = trial_as_run(plan, context)
        self._plan = plan
        self._context = context
        self._controls = Controls()
        self._allocation = trial_allocation(plan, context.protocol, context.seed)
        self._trial_id = context.knowledge.trial_id()
        self._run: FleetRun | None = None
        self._screens: TrialScreens | None = None
        self._timestep = 0
        self._pending: StepFleet | StartFleet | None = None
        self._due_ns = 0
        self._sources = np.zeros(plan.robots, dtype=np.int32)
        self._decided = (-1, ChoiceSource.NONE, ChoiceFlag.NO_CHOICE)
        self._could_be_chosen = np.zeros(plan.robots, dtype=np.bool_)
        known = context.knowledge.artefacts
        # A fit that failed was recorded as a deviation; the trial runs without it.
        self._policy_id = plan.policy_id if plan.policy_id in known else UNIFORM_RANDOM
        self._scorer_id = plan.scorer_id if plan.scorer_id in known else ""
        keys = context.protocol.keys
        self._numbers = NumberEntry(keys.robots, plan.robots)
        self._watch = SwitchWatch(context.protocol, self._trial_id)
        self._countdown = 0
        self._goals = 0
        self._over = False
        self._key_actions = key_actions(keys, context.description)

    def enter(self, t_ns: int, out: Outbox) -> bool:  # noqa: ARG002 - stages are entered alike
        """Wait for the operator, except where nobody operates; skip a practice passed before."""
        if self._plan.attempt > 1 and self._context.knowledge.practice_passed:
            return True
        if self._plan.allocation == "none":
            self._start_fleet(out)
        return False

    def handle(self, given: Input, out: Outbox) -> bool:
        """Take in keys, clock and fleet."""
        if isinstance(given, KeyChanged):
            self._key(given, out)
        elif isinstance(given, PointerPressed):
            self._pointer(given, out)
        elif isinstance(given, TimestepDue) and self._run:
            if self._countdown:
                self._count_down(given.t_ns, out)
            else:
                self._timestep_due(given, self._run, out)
        elif isinstance(given, FleetObserved) and self._answers(given):
            self._pending, answered = None, self._pending
            if isinstance(answered, StartFleet):
                self._started(given, out)
            elif self._run and answered:
                return self._stepped(given, self._run, answered, out)
        return False

    def _answers(self, given: FleetObserved) -> bool:
        return self._pending is not None and given.request_id == self._pending.request_id

    # Keys and pointer

    def _key(self, given: KeyChanged, out: Outbox) -> None:
        keys = self._context.protocol.keys
        if not given.down:
            self._controls.release(given.key)
        elif self._run is None:
            if given.key == keys.confirm and self._pending is None:
                self._start_fleet(out)
        elif given.key in self._key_actions:
            self._controls.press(given.key)
        elif isinstance(manual := self._allocation, ManualAllocation):
            for robot in self._numbers.press(given.key, given.t_ns):
                self._choose(manual.select, robot, "number", given.t_ns, out)
            if given.key == keys.next_robot:
                self._numbers.forget()
                self._choose(lambda _: manual.select_next(), -1, "tab", given.t_ns, out)
            elif isinstance(manual, SuggestedAllocation) and given.key == keys.accept:
                self._choose(lambda _: manual.accept(), -1, "accept", given.t_ns, out)

    def _choose(
        self, select: Callable[[int], int], robot: int, cause: str, t_ns: int, out: Outbox
    ) -> None:
        """Let the operator choose; a choice of the robot operated already is no switch."""
        before = self._allocation.operated
        if select(robot) >= 0:
            self._switched(before, cause, t_ns, out)

    def _pointer(self, given: PointerPressed, out: Outbox) -> None:
        if self._run is None:
            if given.target == "confirm" and self._pending is None:
                self._start_fleet(out)
        elif isinstance(self._allocation, ManualAllocation) and given.target.startswith("robot:"):
            robot = given.target.removeprefix("robot:")
            if robot.isdecimal():
                self._choose(self._allocation.select, int(robot), "pointer", given.t_ns, out)

    def _switched(self, before: int, cause: str, t_ns: int, out: Outbox) -> None:
        timestep = self._timestep + (1 if self._pending else 0)
        to, source = self._allocation.operated, self._allocation.source
        out.events.append(Switched(t_ns, self._trial_id, timestep, before, to, source, cause))
        if source == ChoiceSource.SCORER or cause == "offer":
            self._watch.switched(t_ns)
            # What the participant holds was meant for the robot before.
            self._controls.robot_switched()
        if self._screens:
            self._screens.switched(t_ns)
            self._show(t_ns, out)

    # The fleet

    def _start_fleet(self, out: Outbox) -> None:
        plan, seed = self._plan, self._context.seed
        seeds = [
            stream_seed(seed, "episode", *plan.starts_key, robot, 1) for robot in range(plan.robots)
        ]
        self._pending = StartFleet(
            request_id=self._context.knowledge.request_id(),
            trial_id=self._trial_id,
            robots=plan.robots,
            seeds=np.array(seeds, dtype=np.uint64),
            policy_id=self._policy_id,
            # The same numbers for the same trial of each condition, so that luck is shared.
            policy_seed=stream_seed(seed, "policy", *plan.starts_key),
            scorer_id=self._scorer_id,
        )
        out.effects += [EnsureDurable(), self._pending]

    def _started(self, given: FleetObserved, out: Outbox) -> None:
        plan = self._plan
        self._run = FleetRun(
            given,
            self._context.seed,
            plan.starts_key,
            restart=self._context.protocol.task.on_end == "reset" and not plan.ends_with_robot,
        )
        self._screens = TrialScreens(plan, self._context, self._run, self._allocation, self._watch)
        self._screens.start(given.t_ns)
        out.events.append(
            trial_started(given, plan, self._trial_id, self._policy_id, self._scorer_id)
        )
        self._choose_automatically(given, out)
        if plan.allocation != "none":
            self._countdown = self._context.protocol.timing.countdown_seconds
        out.effects.append(self._pace())
        self._show(given.t_ns, out)

    def _count_down(self, t_ns: int, out: Outbox) -> None:
        """A second of the countdown is over; what was tapped in it does not act."""
        self._countdown -= 1
        if not self._countdown:
            self._controls.timestep_done()
            if self._screens:
                self._screens.start(t_ns)
            out.effects.append(self._pace())
        self._show(t_ns, out)

    def _pace(self) -> SetPace:
        if self._countdown:
            return SetPace(1.0)
        rate = self._context.protocol.timing.timesteps_per_second
        return SetPace(rate, unhurried=self._plan.allocation != "none")

    def _choose_automatically(self, given: FleetObserved, out: Outbox) -> None:
        if isinstance(self._allocation, SuggestedAllocation) and self._run:
            self._allocation.renew(given.scores, self._run.available)
        elif isinstance(self._allocation, AssistedAllocation) and self._run:
            before = self._allocation.operated
            cause = self._allocation.rechoose(given.scores, self._run.available)
            if cause:
                self._switched(before, cause, given.t_ns, out)
            self._watch.announce(self._allocation, given.t_ns, self._timestep, out)
        elif isinstance(self._allocation, OfferAllocation) and self._run:
            before = self._allocation.operated
            cause = self._allocation.renew(given.scores, self._run.available)
            if cause:
                self._switched(before, cause, given.t_ns, out)

    def _timestep_due(self, given: TimestepDue, run: FleetRun, out: Outbox) -> None:
        if self._pending:
            out.events.append(TimestepSkipped(given.t_ns, self._trial_id, self._timestep))
            return
        if isinstance(self._allocation, ManualAllocation):
            for robot in self._numbers.due(given.t_ns):
                self._choose(self._allocation.select, robot, "number", given.t_ns, out)
        operated = self._allocation.operated
        key = self._controls.newest()
        actions, self._sources = decide_actions(
            run.now.policy_actions,
            run.available,
            operated,
            None if key is None else self._key_actions[key],
            self._context.description.idle_action,
            drives_itself=self._plan.allocation == "correction",
        )
        self._due_ns = given.t_ns
        self._pending = StepFleet(
            request_id=self._context.knowledge.request_id(),
            actions=actions,
            active=run.available,
            reset=run.restarting,
            seeds=run.seeds(),
        )
        self._could_be_chosen = run.available
        if isinstance(self._allocation, OfferAllocation):
            self._could_be_chosen = self._allocation.can_be_chosen(run.available)
        # The choice of this timestep is made: a key from now on belongs to the next.
        self._decided = (operated, self._allocation.source, self._allocation.flag())
        if isinstance(self._allocation, SuggestedAllocation):
            suggested = self._allocation.suggested
            out.events.append(Suggestion(given.t_ns, self._trial_id, self._timestep, suggested))
        driven = operated >= 0 and self._sources[operated] == ActionSource.OPERATOR
        self._allocation.timestep_done(driven=bool(driven))
        self._controls.timestep_done()
        out.effects.append(self._pending)

    def _stepped(
        self, given: FleetObserved, run: FleetRun, step: StepFleet | StartFleet, out: Outbox
    ) -> bool:
        assert isinstance(step, StepFleet)  # noqa: S101 - the caller told the two apart
        before = run.now
        operated, source, flag = self._decided
        row = Timestep(
            t_ns=given.t_ns,
            due_ns=self._due_ns,
            trial_id=self._trial_id,
            timestep=self._timestep,
            robots=run.robots,
            operated=operated,
            choice_source=source,
            choice_flag=flag,
            states=before.states,
            actions=step.actions,
            action_sources=self._sources,
            rewards=given.rewards,
            outcomes=given.outcomes,
            available=self._could_be_chosen.astype(np.int32),
            scores=before.scores,
        )
        out.events.append(row)
        if operated >= 0 and row.action_sources[operated] == ActionSource.OPERATOR:
            self._watch.demonstrated(given.t_ns, self._due_ns, self._timestep, out)
        place = self._plan.place
        if place.phase not in (Phase.PRACTICE, Phase.FOUR):
            kept = self._context.knowledge.timesteps
            kept.setdefault((place.phase, place.condition), KeptTimesteps()).add(row, place.phase)
        ended = run.observe(given)
        out.events += [
            episode_ended(episode, given.t_ns, self._trial_id, self._timestep) for episode in ended
        ]
        self._goals += sum(
            each.robot == operated and each.outcome == Outcome.GOAL for each in ended
        )
        if self._screens:
            self._screens.observe(before, given, step.reset)
        self._timestep += 1
        all_over = not (run.available | run.restarting).any()
        over = self._timestep >= self._plan.timesteps or all_over
        needed = self._plan.goals_needed
        over = over or (self._plan.ends_with_robot and bool(ended))
        if over or (needed and self._goals >= needed):
            judge_practice(self._plan, self._context, self._trial_id, self._goals, given.t_ns, out)
            self._end(given.t_ns, out, complete=True)
            return True
        self._choose_automatically(given, out)
        self._show(given.t_ns, out)
        return False

    def _end(self, t_ns: int, out: Outbox, *, complete: bool) -> None:
        reward = self._run.team_reward if self._run else 0.0
        out.events.append(TrialEnded(t_ns, self._trial_id, self._timestep, reward, complete))
        place = self._plan.place
        if complete and place.phase == Phase.THREE:
            rewards = self._context.knowledge.block_rewards
            rewards.setdefault(place.condition, []).append(reward)
        out.effects += [SetPace(0.0), StopFleet(), EnsureDurable()]
        self._over = True

    # Standing still

    def pause(self, out: Outbox) -> None:
        """Stop the clock; keys held are let go."""
        self._controls.release_all()
        if self._run:
            out.effects.append(SetPace(0.0))

    def resume(self, t_ns: int, out: Outbox) -> None:
        """Start the clock again."""
        if self._run:
            out.effects.append(self._pace())
            if self._screens:
                self._screens.resumed(t_ns)

    def break_off(self, t_ns: int, out: Outbox) -> None:
        """Close the trial as incomplete."""
        if self._run and not self._over:
            self._end(t_ns, out, complete=False)

    def _show(self, t_ns: int, out: Outbox) -> None:
        if self._screens and self._screens.worth_showing(self._timestep):
            self._screens.update(t_ns, self._timestep, self._countdown)
            out.effects.append(Show(self._screens.screen()))

    def screen(self) -> Screen:
        """Return the ready screen before the start, then the fleet."""
        if self._screens is not None:
            return self._screens.screen()
        return first_screen(self._plan, self._context)
