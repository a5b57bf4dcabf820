"""The shipped instruments: their scores, by the rules of their sources."""

from __future__ import annotations

import pytest

from study.loading import load_questionnaire, shipped_protocols
from study.questionnaire import Questionnaire


def shipped(name: str) -> Questionnaire:
    """Load a shipped instrument."""
    return load_questionnaire(name, shipped_protocols())


def test_the_paper_s_questions_have_no_score() -> None:
    """Q1 and Q2 are analysed one by one."""
    assert shipped("ease_and_success").scores({"q1": 3, "q2": 5}) == {}


@pytest.mark.parametrize(
    ("odd", "even", "score"), [(5, 1, 100.0), (1, 5, 0.0), (3, 3, 50.0), (4, 2, 75.0)]
)
def test_sus(odd: int, even: int, score: float) -> None:
    """Brooke: odd items count v - 1, even ones 5 - v, the sum times 2.5."""
    sus = shipped("sus")
    answers = {item.id: even if place % 2 else odd for place, item in enumerate(sus.items)}
    by_hand = 2.5 * (5 * (odd - 1) + 5 * (5 - even))
    assert sus.scores(answers) == {"sus": pytest.approx(by_hand)}
    assert by_hand == score


def test_raw_tlx_is_the_mean_of_six_ratings() -> None:
    """Ratings go from 0 to 100 in steps of 5; unweighted, their mean is the score."""
    tlx = shipped("nasa_tlx")
    ratings = [0, 5, 40, 100, 75, 20]
    assert [item.id for item in tlx.items][3] == "performance"
    answers = {item.id: value for item, value in zip(tlx.items, ratings, strict=True)}
    assert tlx.scores(answers) == {"raw_tlx": 40.0}
    assert tlx.accepts(95)
    assert not tlx.accepts(93)


def test_trust_reverses_the_five_items_of_distrust() -> None:
    """Full trust is 7, full distrust 1; the middle of the scale stays the middle."""
    trust = shipped("trust")
    assert len(trust.items) == 12
    best = {item.id: 1 if place < 5 else 7 for place, item in enumerate(trust.items)}
    worst = {name: 8 - value for name, value in best.items()}
    middle = dict.fromkeys(best, 4)
    assert [trust.scores(a)["trust"] for a in (best, worst, middle)] == [7.0, 1.0, 4.0]
