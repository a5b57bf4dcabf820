"""Questionnaires: the paper's wording, and what a file of one may hold."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import ROOT
from study.errors import ProtocolError
from study.questionnaire import Questionnaire, parse_questionnaire
from study.validation import checked

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


SCALES = """
[[scales]]
name = "ease"
method = "mean"
items = ["q1", "q9"]
"""


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            [("high = 7", "high = 1"), ('id = "q2"', 'id = "q1"')],
            ["high: 1 given", "an id is given twice: q1, q1", '"q9" is no item'],
        ),
        (
            [("version = 1", "version = 0"), ("high = 7", "high = 6"), ('"q2"', '"q1"')],
            ["version: 0 given", '"7" is no value from 1 to 6', "given twice", '"q9" is no item'],
        ),
        (
            [('id = "q2"', 'id = "q1"\nkind = "chioce"\nleast = -1')],
            ['kind: "chioce" given', "least: -1 given", "given twice", '"q9" is no item'],
        ),
        (
            [('id = "q2"', 'id = "q2"\noptions = ["a", "b"]\noptional = true\nleast = 1000000')],
            ["options:", "optional:", "least: 1000000 given", '"q9" is no item'],
        ),
        # What is meant by an id that is wrong nobody knows yet.
        ([('id = "q2"', 'id = "Q 9"')], ['items.2.id: "Q 9" given']),
        (
            [('name = "ease_and_success"', 'name = "ease"'), ("low = 1", "lo = 1")],
            ["lo: unknown key", '"q9" is no item', 'name: "ease" given; must be the file'],
        ),
        ([("high = 7", 'high = "7"')], ['high: "7" given; allowed: a whole number', '"q9"']),
    ],
)
def test_all_mistakes_of_a_questionnaire_are_told_at_once(
    changes: list[tuple[str, str]], expected: list[str]
) -> None:
    """As of protocols: one that is wrong by itself hides none in what is beside it."""
    text = TEXT + SCALES
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    with pytest.raises(ProtocolError) as caught:
        parse_questionnaire(text, "q.toml", name="ease_and_success")
    problems = caught.value.problems
    assert len(problems) == len(expected), problems
    for words, problem in zip(expected, problems, strict=True):
        assert words in problem


anything = st.recursive(
    st.none() | st.booleans() | st.integers(-2, 9) | st.text("q1 ", max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
        st.sampled_from(["id", "name", "items", "reverse", "text", "kind"]), inner, max_size=4
    ),
)  # fmt: skip


@given(st.dictionaries(st.sampled_from(["items", "scales", "labels", "low", "high"]), anything))
def test_whatever_stands_there_is_said_to_be_wrong(given_tables: dict[str, object]) -> None:
    """Looking on past a mistake never ends in an error of the program."""
    found = checked(Questionnaire, {**tomllib.loads(TEXT), **given_tables})
    if found.made is None:
        assert found.problems
