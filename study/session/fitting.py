"""The fit stage: gather the training data, ask for the fit, wait, put it in force."""

from __future__ import annotations

import hashlib
import json

from study.events.events import Deviation, FitApplied, FitRequested
from study.events.inputs import FitCompleted, FitFailed, FitTimedOut, Input
from study.screens import Screen, WaitScreen
from study.seeding import stream_seed
from study.session.context import Context, Outbox
from study.session.effects import EnsureDurable, RequestFit
from study.session.plan import FitPlan
from study.session.stage import QuietStage
from study.training_sets import arrays_sha256, choice_sets, demonstrations


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
        protocol, knowledge = context.protocol, context.knowledge
        rows = [
            row
            for phase, condition in plan.sources
            for row in knowledge.timesteps.get((phase, condition), [])
        ]
        state_size = len(context.description.state_fields)
        if plan.kind == "policy":
            member = protocol.policy
            arrays = demonstrations(rows, state_size).arrays()
        else:
            member = protocol.scorers[plan.member]
            arrays = choice_sets(rows, protocol.phase_two.robots, state_size).arrays()
        self._request_id = knowledge.request_id()
        out.events.append(
            FitRequested(
                t_ns=t_ns,
                request_id=self._request_id,
                artefact_id=plan.artefact_id,
                kind=plan.kind,
                algorithm=member.name,
                rows=len(arrays["states"]),
                data_sha256=arrays_sha256(arrays),
            )
        )
        out.effects.append(
            RequestFit(
                request_id=self._request_id,
                artefact_id=plan.artefact_id,
                kind=plan.kind,
                algorithm=member.name,
                parameters_json=json.dumps(member.parameters, sort_keys=True),
                arrays=arrays,
                seed=stream_seed(context.seed, "fit", self._request_id),
                budget_seconds=member.fit_budget_seconds,
            )
        )
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
