"""Questionnaires: the paper's wording, and what a file of one may hold."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import ROOT
from study.errors import ProtocolError
from study.questionnaire import Questionnaire, parse_questionnaire

TEXT = (ROOT / "protocols" / "questionnaires" / "ease_and_success.toml").read_text()


def paper() -> Questionnaire:
    """Return the paper's questionnaire."""
    return parse_questionnaire(TEXT, "ease_and_success.toml")


def test_wording_is_the_paper_s() -> None:
    """Both sentences and the three labels of the seven-point scale."""
    asked = paper()
    assert {item.id: item.text for item in asked.items} == {
        "q1": "It was easy to guide the robots to their goals",
        "q2": "I was successful at guiding the robots",
    }
    assert asked.value_labels() == (
        (1, "Strongly Disagree"),
        (4, "Neither Disagree nor Agree"),
        (7, "Strongly Agree"),
    )


@given(st.integers())
def test_answers_lie_on_the_scale(value: int) -> None:
    """One to seven, and nothing else."""
    assert paper().accepts(value) == (1 <= value <= 7)


def test_a_questionnaire_without_items_is_refused() -> None:
    """One message that names what is missing; an empty list of items is none either."""
    head = TEXT[: TEXT.index("[[items]]")]
    for text in (head, f"items = []\n{head}"):
        with pytest.raises(ProtocolError, match="items") as caught:
            parse_questionnaire(text, "q.toml")
        assert len(caught.value.problems) == 1


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("high = 7", "high = 1", "high: 1 given"),
        ("high = 7", "high = 101", "high: 101 given"),
        ("low = 1", "lo = 1", 'lo: unknown key; did you mean "low"?'),
        ('id = "q2"', 'id = "q1"', "an id is given twice"),
        ('id = "q2"', 'id = "Q 2"', 'items.2.id: "Q 2" given'),
        ("high = 7", "high = 5", '"7" is no value from 1 to 5'),
        ("version = 1", "version", "not TOML"),
    ],
)
def test_wrong_questionnaire(old: str, new: str, words: str) -> None:
    """One message a problem, as for protocols."""
    assert old in TEXT
    with pytest.raises(ProtocolError) as caught:
        parse_questionnaire(TEXT.replace(old, new), "q.toml")
    assert len(caught.value.problems) == 1
    assert words in caught.value.problems[0]
