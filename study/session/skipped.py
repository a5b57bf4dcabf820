"""Stages that a plan holds in case, and that are passed over because the case did not arise."""

from __future__ import annotations

from study.events.events import Deviation
from study.session.context import Context, Knowledge, Outbox
from study.session.plan import FitPlan, PagesPlan, PreparationPlan, StagePlan, TrialPlan
from study.session.stage import PassingStage


def is_passed_over(plan: StagePlan, knowledge: Knowledge) -> bool:
    """Whether nobody asked for a stage, or what it needs is not there."""
    if not isinstance(plan, PagesPlan | TrialPlan | FitPlan | PreparationPlan):
        return False
    unasked = plan.repeat and plan.repeat not in knowledge.repeats
    return bool(unasked or (plan.needs and plan.needs not in knowledge.artefacts))


class SkippedStage(PassingStage):
    """Over as soon as it is entered."""

    kind = "skipped"

    def __init__(self, plan: StagePlan, context: Context) -> None:
        super().__init__(context)
        self._plan = plan

    def enter(self, t_ns: int, out: Outbox) -> bool:
        """Nothing is to be done; a correction round that cannot be held is a deviation."""
        plan = self._plan
        if isinstance(plan, PagesPlan) and plan.needs:
            text = f"{plan.needs} could not be fitted, so it cannot drive a fleet"
            out.events.append(Deviation(t_ns, f"{plan.name}_skipped", text, -1))
        return True
