"""The gate of a scorer: whether a fit is good enough on held-out trials, and what follows."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

from study.events.events import Deviation
from study.events.fit_events import FitGateJudged
from study.events.inputs import FitCompleted, FitFailed, FitTimedOut
from study.protocol import Condition
from study.scorer_settings import MANUAL, GatePart
from study.session.context import Context, Outbox
from study.session.plan import FitPlan, TrialPlan, scorer_of

FitEnd = FitCompleted | FitFailed | FitTimedOut


@dataclasses.dataclass(frozen=True, slots=True)
class Measured:
    """What a gate looks at; NaN where it was not measured.

    Attributes:
        likelihood_gain: held-out log-likelihood a choice above chance, nats.
        top1_gain: held-out top-1 above chance.
        calibration_error: on held-out choices.
    """

    likelihood_gain: float
    top1_gain: float
    calibration_error: float


def measured(given: FitEnd) -> Measured:
    """Return what a gate looks at of the answer to a fit."""
    found: Mapping[str, float] = {}
    if isinstance(given, FitCompleted):
        found = dict(zip(given.metric_names, given.metric_values.tolist(), strict=False))

    def metric(name: str) -> float:
        return found.get(f"held_out_{name}", math.nan)

    return Measured(
        likelihood_gain=metric("log_likelihood_per_choice") - metric("chance_log_likelihood"),
        top1_gain=metric("top1") - metric("chance_top1"),
        calibration_error=metric("calibration_error"),
    )


def shortcoming(gate: GatePart, found: Measured, given: FitEnd) -> str:
    """Return why a fit does not pass, in words; empty if it does."""
    if isinstance(given, FitFailed):
        return f"the fit failed: {given.reason}"
    if isinstance(given, FitTimedOut):
        return f"the fit ran over its budget of {given.budget_seconds:g} s"
    # What is not a number reaches no threshold.
    checks = (
        (
            found.likelihood_gain >= gate.min_likelihood_gain,
            f"held-out log-likelihood {_written(found.likelihood_gain)} nats a choice above "
            f"chance, at least {gate.min_likelihood_gain:g} needed",
        ),
        (
            found.top1_gain >= gate.min_top1_gain,
            f"held-out top-1 {_written(found.top1_gain)} above chance, at least "
            f"{gate.min_top1_gain:g} needed",
        ),
        (
            found.calibration_error <= gate.max_calibration_error,
            f"calibration error {_written(found.calibration_error)}, at most "
            f"{gate.max_calibration_error:g} allowed",
        ),
    )
    if all(math.isnan(value) for value in dataclasses.astuple(found)):
        return "nothing was held out: too few trials with choices"
    return "; ".join(text for reached, text in checks if not reached)


def _written(value: float) -> str:
    return "not measured" if math.isnan(value) else f"{value:.3f}"


def judge(plan: FitPlan, context: Context, given: FitEnd, out: Outbox) -> None:
    """Hold the answer to a fit against its scorer's gate; note and record what follows.

    Args:
        plan: of the fit; one whose attempt is 0 is not judged.
        context: where it is noted.
        given: the answer.
        out: for the events.
    """
    gate = context.protocol.scorers[plan.member].gate if plan.attempt else None
    if gate is None:
        return
    found = measured(given)
    reason = shortcoming(gate, found, given)
    decision = "use"
    if reason:
        decision = "repeat" if plan.attempt < gate.attempts else gate.on_failure
    fallback = gate.fallback if decision == "fallback" else ""
    out.events.append(
        FitGateJudged(
            t_ns=given.t_ns,
            request_id=given.request_id,
            artefact_id=plan.artefact_id,
            attempt=plan.attempt,
            attempts=gate.attempts,
            passed=not reason,
            decision=decision,
            fallback=fallback,
            likelihood_gain=found.likelihood_gain,
            top1_gain=found.top1_gain,
            calibration_error=found.calibration_error,
            min_likelihood_gain=gate.min_likelihood_gain,
            min_top1_gain=gate.min_top1_gain,
            max_calibration_error=gate.max_calibration_error,
            reason=reason,
        )
    )
    knowledge = context.knowledge
    knowledge.replaced.pop(plan.artefact_id, None)
    if decision == "repeat":
        knowledge.repeats.add(plan.attempt + 1)
    elif decision == "fallback":
        replaced = MANUAL if fallback == MANUAL else scorer_of(fallback)
        knowledge.replaced[plan.artefact_id] = replaced
    elif decision == "end":
        knowledge.stop_reason = f"{plan.artefact_id} did not pass its gate"
    if reason:
        text = f"{plan.artefact_id}, attempt {plan.attempt} of {gate.attempts}: {reason}; "
        what = f"{decision} to {fallback}" if fallback else decision
        out.events.append(Deviation(given.t_ns, "fit_gate_failed", text + what, -1))


def _replacement(scorer_id: str, context: Context) -> str:
    """Return what runs in a scorer's place: a scorer, `MANUAL`, or empty for itself."""
    knowledge = context.knowledge
    found = knowledge.replaced.get(scorer_id, "")
    return found if found in ("", *knowledge.artefacts) else MANUAL


def trial_as_run(plan: TrialPlan, context: Context) -> TrialPlan:
    """Return a trial as it is run: with what takes the place of a scorer that did not pass."""
    found = _replacement(plan.scorer_id, context)
    if not found:
        return plan
    if found != MANUAL:
        return dataclasses.replace(plan, scorer_id=found)
    # Who chooses has to see what there is to choose from.
    view = "tiles" if plan.view == "operated_only" else plan.view
    return dataclasses.replace(plan, allocation="manual", view=view, dwell=0, scorer_id="")


def condition_as_run(condition: Condition, context: Context) -> Condition:
    """Return a condition as it is run; see `trial_as_run`."""
    scorer = scorer_of(condition.scorer) if condition.scorer else ""
    if _replacement(scorer, context) != MANUAL:
        return condition
    view = "tiles" if condition.view == "operated_only" else condition.view
    return condition.model_copy(
        update={"allocation": "manual", "view": view, "dwell": 0, "scorer": ""}
    )
