"""What the pages say agrees with the protocol."""

from __future__ import annotations

from study.events.codes import Phase
from study.loading import load_protocol
from study.messages import messages_for
from study.protocol import Protocol
from study.session.context import Context, Knowledge
from study.session.page_texts import Page, pages
from study.session.plan import PagesPlan, Place


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
