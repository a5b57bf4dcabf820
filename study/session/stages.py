"""From a plan to the stage that carries it out."""

from __future__ import annotations

from study.session.check import CheckStage
from study.session.context import Context
from study.session.fitting import FitStage, PreparationStage
from study.session.pages import PagesStage
from study.session.plan import (
    BreakPlan,
    CheckPlan,
    FitPlan,
    PagesPlan,
    PreparationPlan,
    RevealPlan,
    StagePlan,
    SurveyPlan,
    TrialPlan,
)
from study.session.resting import BreakStage
from study.session.reveal import RevealStage
from study.session.skipped import SkippedStage, is_passed_over
from study.session.stage import Stage
from study.session.survey import SurveyStage
from study.session.trial import TrialStage


def make_stage(plan: StagePlan, context: Context) -> Stage:
    """Return the stage of a plan."""
    if is_passed_over(plan, context.knowledge):
        return SkippedStage(plan, context)
    if isinstance(plan, PagesPlan):
        return PagesStage(plan, context)
    if isinstance(plan, TrialPlan):
        return TrialStage(plan, context)
    if isinstance(plan, FitPlan):
        return FitStage(plan, context)
    if isinstance(plan, PreparationPlan):
        return PreparationStage(plan, context)
    if isinstance(plan, SurveyPlan):
        return SurveyStage(plan, context)
    if isinstance(plan, BreakPlan):
        return BreakStage(plan, context)
    if isinstance(plan, CheckPlan):
        return CheckStage(plan, context)
    assert isinstance(plan, RevealPlan)  # noqa: S101 - the union has no other member
    return RevealStage(plan, context)
