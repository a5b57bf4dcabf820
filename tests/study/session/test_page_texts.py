"""What the pages say agrees with the protocol."""

from __future__ import annotations

import dataclasses

from study.events.codes import Phase
from study.loading import load_protocol
from study.messages import messages_for
from study.protocol import Protocol
from study.screens import RevealScreen, SurveyScreen
from study.session.check import CheckStage
from study.session.context import Context, Knowledge
from study.session.page_texts import Page, pages
from study.session.plan import CheckPlan, PagesPlan, Place, RevealPlan, TrialPlan
from study.session.reveal import RevealStage
from study.session.sequence import stage_plans
from study.session.trial_screens import ready_screen


def context_of(protocol: Protocol) -> Context:
    """Return what the pages are written from, before anything was learned."""
    loaded = load_protocol("every_screen")
    order = tuple(condition.name for condition in protocol.conditions)
    return Context(
        protocol, loaded.description, loaded.questionnaires, "P01", 7, order, Knowledge(),
        messages_for("en"),
    )  # fmt: skip


def every_screen() -> Protocol:
    """Return the shipped protocol."""
    return load_protocol("every_screen").protocol


def page_before(condition: str) -> Page:
    """Return the page before a condition's block."""
    place = Place(Phase.THREE, block=1, condition=condition)
    return pages(PagesPlan("phase_three", place), context_of(every_screen()))[0]


def test_the_illustration_shows_what_the_text_says_is_seen() -> None:
    """All robots are shown where all are seen, and one where one is."""
    all_seen, one_seen = page_before("switched_at_random"), page_before("assisted")
    assert any(text.startswith("You see all robots") for text in all_seen.paragraphs)
    assert any(text.startswith("You see only the robot") for text in one_seen.paragraphs)
    assert (all_seen.figure, one_seen.figure) == ("assisted_all", "assisted")
    assert page_before("suggested").figure == "choose"


def test_answers_are_called_wrong_nowhere_only_where_none_can_be() -> None:
    """A comprehension check has wrong answers; questions for a view have none."""
    place = Place(Phase.PRACTICE)
    asked = every_screen()
    unasked = asked.model_copy(update={"comprehension": None})
    told = {
        name: " ".join(pages(PagesPlan("welcome", place), context_of(protocol))[0].paragraphs)
        for name, protocol in (("asked", asked), ("unasked", unasked))
    }
    assert "no wrong answers" in told["unasked"]
    assert "no wrong answers" not in told["asked"]
    assert "where you are asked for your view no answer is wrong" in told["asked"]


def first_practice(protocol: Protocol) -> TrialPlan:
    """Return the plan of the first practice."""
    found = (plan for plan in stage_plans(protocol, ("manual",)) if isinstance(plan, TrialPlan))
    return next(found)


def test_one_question_of_the_check_is_one_question() -> None:
    """And several are several, also where they are asked again."""
    one = every_screen()
    part = one.comprehension
    assert part is not None
    assert len(part.questions) == 1
    other = part.questions[0].model_copy(update={"id": "other"})
    several = one.model_copy(
        update={"comprehension": part.model_copy(update={"questions": (*part.questions, other)})}
    )
    for protocol, prompt, again in (
        (one, "A question about how it works.", "Then the same question once more."),
        (several, "A few questions about how it works.", "Then the same questions once more."),
    ):
        context = context_of(protocol)
        screen = CheckStage(CheckPlan(Place(Phase.PRACTICE), 1), context).screen()
        assert isinstance(screen, SurveyScreen)
        assert screen.prompt.startswith(prompt)
        context.knowledge.comprehension_wrong = (part.questions[0].id,)
        told = pages(PagesPlan("explanation", Place(Phase.PRACTICE)), context)
        assert told[0].subtitle == again


def test_one_question_after_the_points_is_one_question() -> None:
    """What comes next is said of as many questions as there are."""
    context = context_of(every_screen())
    asked = context.questionnaires["ease_and_success"]
    single = asked.model_copy(update={"items": asked.items[:1]})
    plan = RevealPlan(Place(Phase.THREE, 1, "manual"), surveys_follow=True)
    hints = []
    for form in (asked, single):
        given = {**context.questionnaires, "ease_and_success": form}
        stage = RevealStage(plan, dataclasses.replace(context, questionnaires=given))
        screen = stage.screen()
        assert isinstance(screen, RevealScreen)
        hints.append(screen.next_hint)
    assert hints == [
        "Next: the same questions again. Your first answers stay as they are.",
        "Next: the same question again. Your first answer stays as it is.",
    ]


def test_a_goal_to_be_reached_once_and_a_practice_shorter_than_a_second_have_words() -> None:
    """Neither "1 time" nor "0 seconds" is said."""
    protocol = every_screen()
    context, plan = context_of(protocol), first_practice(protocol)
    rate = protocol.timing.timesteps_per_second

    def told(goals: int, seconds: float) -> str:
        steps = round(seconds * rate)
        changed = dataclasses.replace(plan, goals_needed=goals, timesteps=steps)
        return ready_screen(changed, context).subtitle

    assert told(1, 1) == (
        "One robot, 1 second. Bring it to its goal once. Begin when you are ready."
    )
    assert "Bring it to its goal 3 times." in told(3, 20)
    assert told(0, 0.5) == "One robot, less than a second. Begin when you are ready."
    short = protocol.model_copy(
        update={"practice": protocol.practice.model_copy(update={"timesteps": 4})}
    )
    page = pages(PagesPlan("practice", Place(Phase.PRACTICE)), context_of(short))[0]
    assert page.subtitle.startswith("Less than a second")
