"""Practice to a criterion: whether it was met, and what follows if it was not."""

from __future__ import annotations

from study.events.events import Deviation
from study.events.participant_events import PracticeChecked
from study.session.context import Context, Outbox
from study.session.plan import TrialPlan


def judge_practice(
    plan: TrialPlan, context: Context, trial_id: int, goals: int, t_ns: int, out: Outbox
) -> None:
    """Record whether a practice with a criterion was passed; others are not judged.

    Args:
        plan: of the practice.
        context: where it is noted.
        trial_id: which fleet run.
        goals: reached by the operated robot.
        t_ns: when the run was over.
        out: for the events.
    """
    if not plan.goals_needed:
        return
    knowledge = context.knowledge
    passed = goals >= plan.goals_needed
    knowledge.practice_passed = passed
    out.events.append(
        PracticeChecked(t_ns, trial_id, plan.attempt, goals, plan.goals_needed, passed)
    )
    if passed or plan.attempt < plan.attempts:
        return
    text = f"{goals} of {plan.goals_needed} goals in attempt {plan.attempt}"
    out.events.append(Deviation(t_ns, "practice_failed", text, trial_id))
    if context.protocol.practice.on_failure == "end":
        knowledge.stop_reason = "the practice was not passed"
