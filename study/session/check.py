"""The comprehension check: questions on the instructions; what was wrong is explained again."""

from __future__ import annotations

from study.events.events import Deviation
from study.events.inputs import Input
from study.events.participant_events import ComprehensionChecked
from study.messages import noted
from study.questionnaire import Item, Questionnaire
from study.seat_settings import ComprehensionPart
from study.session.context import Context, Outbox
from study.session.plan import CheckPlan
from study.session.survey import Form

NAME = "comprehension"


class CheckStage(Form):
    """One attempt: all questions; skipped once an attempt was right in full."""

    kind = "check"

    def __init__(self, plan: CheckPlan, context: Context) -> None:
        assert context.protocol.comprehension is not None  # noqa: S101 - planned only with one
        self._part: ComprehensionPart = context.protocol.comprehension
        self._attempt = plan.attempt
        super().__init__(_questionnaire(self._part), plan.place, f"attempt_{plan.attempt}", context)

    def enter(self, t_ns: int, out: Outbox) -> bool:
        """Ask, unless all is understood."""
        super().enter(t_ns, out)
        return self._context.knowledge.comprehension_wrong == ()

    def handle(self, given: Input, out: Outbox) -> bool:
        """Take in answers; judge them when the last is confirmed."""
        if not super().handle(given, out):
            return False
        values = self.values()
        wrong = tuple(q.id for q in self._part.questions if values[q.id] != q.correct)
        asked = len(self._part.questions)
        knowledge = self._context.knowledge
        knowledge.comprehension_wrong = wrong
        out.events.append(
            ComprehensionChecked(
                given.t_ns, self._attempt, asked - len(wrong), asked, not wrong, wrong
            )
        )
        if wrong and self._attempt > self._part.explanations:
            text = f"wrong in attempt {self._attempt}: {', '.join(wrong)}"
            out.events.append(Deviation(given.t_ns, "comprehension_failed", text, -1))
            if self._part.on_failure == "end":
                knowledge.stop_reason = "the instructions were not understood"
        return True

    def header(self) -> str:
        """Return the words at the top left."""
        return self._context.say("Before we start")


def _questionnaire(part: ComprehensionPart) -> Questionnaire:
    return Questionnaire(
        name=NAME,
        version=1,
        title=noted("Is everything clear?"),
        prompt=noted("A question about how it works. You can ask the experimenter.")
        if len(part.questions) == 1
        else noted("A few questions about how it works. You can ask the experimenter."),
        items=tuple(
            Item(id=question.id, text=question.text, kind="choice", options=question.options)
            for question in part.questions
        ),
        items_per_page=2,
    )
