"""The fit stage: gather the training data, ask for the fit, wait, put it in force.

Beside it the stage that asks for a fit in the background and does not wait.
"""

from __future__ import annotations

import hashlib
import json

from study.events.events import Deviation, FitApplied, FitRequested
from study.events.fit_events import PreparationRequested, WarmStarted
from study.events.inputs import FitCompleted, FitFailed, FitTimedOut, Input
from study.screens import Screen, WaitScreen
from study.seeding import stream_seed
from study.session.context import Context, Outbox, Preparation
from study.session.effects import EnsureDurable, RequestFit
from study.session.fit_gate import FitEnd, judge
from study.session.plan import FitPlan, PreparationPlan
from study.session.rules import WARM_STARTS
from study.session.stage import PassingStage, QuietStage
from study.training_sets import arrays_sha256, choice_sets, joined


def fit_request(
    plan: FitPlan | PreparationPlan, context: Context, start: bytes = b""
) -> RequestFit:
    """Return the request for a fit to what the session knows now."""
    protocol, knowledge = context.protocol, context.knowledge
    kept = [knowledge.timesteps[key] for key in plan.sources if key in knowledge.timesteps]
    state_size = len(context.description.state_fields)
    if plan.kind == "policy":
        member = protocol.policy
        parts = [each.demonstrations.collected(state_size) for each in kept]
        arrays = joined(parts, state_size).arrays()
    else:
        member = protocol.scorers[plan.member]
        robots, round_ = protocol.phase_two.robots, protocol.correction_round
        rows = [row for each in kept for row in each.choices]
        sets = (
            choice_sets(rows, max(robots, round_.offered), state_size, of_larger=True)
            if round_
            else choice_sets(rows, robots, state_size)
        )
        arrays = sets.arrays()
    request_id = knowledge.request_id()
    # One stream for a scorer, so that a later fit holds out the same trials as an earlier one.
    stream = ("fit", request_id)
    if plan.kind == "scorer" and context.rules >= WARM_STARTS:
        stream = (f"fit {plan.artefact_id}", 0)
    return RequestFit(
        request_id=request_id,
        artefact_id=plan.artefact_id,
        kind=plan.kind,
        algorithm=member.name,
        parameters_json=json.dumps(member.parameters, sort_keys=True),
        arrays=arrays,
        seed=stream_seed(context.seed, *stream),
        budget_seconds=member.fit_budget_seconds,
        start=start,
        background=isinstance(plan, PreparationPlan),
    )


class PreparationStage(PassingStage):
    """Asks for a fit in the background, and is over at once."""

    kind = "preparation"

    def __init__(self, plan: PreparationPlan, context: Context) -> None:
        super().__init__(context)
        self._plan = plan

    def enter(self, t_ns: int, out: Outbox) -> bool:
        """Ask for the fit, if there is anything to fit to."""
        request = fit_request(self._plan, self._context)
        rows = len(request.arrays["states"])
        if rows:
            self._context.knowledge.preparing[request.request_id] = request.artefact_id
            out.events.append(
                PreparationRequested(
                    t_ns=t_ns,
                    request_id=request.request_id,
                    artefact_id=request.artefact_id,
                    algorithm=request.algorithm,
                    rows=rows,
                    data_sha256=arrays_sha256(request.arrays),
                )
            )
            out.effects.append(request)
        return True


def take_preparation(given: FitEnd, context: Context) -> bool:
    """Keep the answer to a fit in the background; return whether it was one.

    One that failed is no loss: the fit that counts then starts from nothing.
    """
    knowledge = context.knowledge
    artefact_id = knowledge.preparing.pop(given.request_id, "")
    if artefact_id and isinstance(given, FitCompleted):
        _keep_preparation(artefact_id, given, context)
    return bool(artefact_id)


def _keep_preparation(artefact_id: str, given: FitCompleted, context: Context) -> None:
    if given.preparation:
        kept = Preparation(given.request_id, given.preparation)
        context.knowledge.preparations[artefact_id] = kept


class FitStage(QuietStage):
    """Waits for one fit. A fit takes effect here and nowhere else."""

    kind = "fit"

    def __init__(self, plan: FitPlan, context: Context) -> None:
        self._plan = plan
        self._context = context
        self._request_id = -1

    def enter(self, t_ns: int, out: Outbox) -> bool:
        """Ask for the fit."""
        plan, context = self._plan, self._context
        before = context.knowledge.preparations.get(plan.artefact_id) if plan.warm else None
        request = fit_request(plan, context, before.content if before else b"")
        self._request_id = request.request_id
        out.events.append(
            FitRequested(
                t_ns=t_ns,
                request_id=request.request_id,
                artefact_id=plan.artefact_id,
                kind=plan.kind,
                algorithm=request.algorithm,
                rows=len(request.arrays["states"]),
                data_sha256=arrays_sha256(request.arrays),
            )
        )
        if before:
            digest = hashlib.sha256(before.content).hexdigest()
            out.events.append(WarmStarted(t_ns, request.request_id, before.request_id, digest))
        out.effects.append(request)
        return False

    def handle(self, given: Input, out: Outbox) -> bool:
        """Put the answer in force; record a failure as a deviation and go on."""
        if not isinstance(given, FitCompleted | FitFailed | FitTimedOut):
            return False
        if given.request_id != self._request_id:
            return False
        plan = self._plan
        if isinstance(given, FitCompleted):
            self._context.knowledge.artefacts.add(plan.artefact_id)
            _keep_preparation(plan.artefact_id, given, self._context)
            out.events.append(
                FitApplied(
                    t_ns=given.t_ns,
                    request_id=given.request_id,
                    artefact_id=plan.artefact_id,
                    kind=plan.kind,
                    weights_sha256=hashlib.sha256(given.weights).hexdigest(),
                    metric_names=given.metric_names,
                    metric_values=given.metric_values,
                    score_grid=given.score_grid,
                )
            )
        elif isinstance(given, FitFailed):
            self._deviate("fit_failed", f"{plan.artefact_id}: {given.reason}", given.t_ns, out)
        else:
            text = f"{plan.artefact_id}: over its budget of {given.budget_seconds:g} s"
            self._deviate("fit_timed_out", text, given.t_ns, out)
        judge(plan, self._context, given, out)
        out.effects.append(EnsureDurable())
        return True

    def _deviate(self, code: str, text: str, t_ns: int, out: Outbox) -> None:
        out.events.append(Deviation(t_ns, code, text, -1))

    def screen(self) -> Screen:
        """Return a screen that asks for a moment's patience."""
        say = self._context.say
        text = (
            say("The robots are learning from you to drive.")
            if self._plan.kind == "policy"
            else say("The robots are learning from you when you take over.")
        )
        return WaitScreen(title=say("One moment"), text=text, progress=-1.0)
