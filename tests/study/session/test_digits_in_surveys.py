"""Digits that answer questions: corrections, and numbers on long scales."""

from __future__ import annotations

import dataclasses

import pytest

from fake_shell import FakeShell, replayed
from short_study import opened, short_study
from study.events.participant_events import AnswerChanged
from study.loading import load_protocol
from study.screens import SurveyScreen
from study.session.answers import SECOND_DIGIT_NS, TypedDigits
from study.session.rules import CORRECTING_DIGITS, NUMBERS_ON_SCALES


def at_survey(rules: int = CORRECTING_DIGITS) -> FakeShell:
    """Go on to the first survey after a block: two scales from 1 to 7 on one page."""
    shell = FakeShell(dataclasses.replace(opened(short_study()), rules=rules))
    shell.go_on_until(lambda: isinstance(shell.screen, SurveyScreen))
    shell.t_ns += 1_000_000_000
    return shell


def values(shell: FakeShell) -> tuple[int | None, ...]:
    """Return the answers on the screen."""
    assert isinstance(shell.screen, SurveyScreen)
    return tuple(item.value for item in shell.screen.items)


def press(shell: FakeShell, *keys: str) -> None:
    """Press keys in turn."""
    for key in keys:
        shell.key(key)


def test_a_digit_after_the_last_answer_corrects_it() -> None:
    """The marked place stays on Enter, and the change is recorded."""
    shell = at_survey()
    press(shell, "3", "5", "6")
    assert isinstance(shell.screen, SurveyScreen)
    assert values(shell) == (3, 6)
    assert shell.screen.focus == 2
    changed = [event for event in shell.events if isinstance(event, AnswerChanged)]
    assert changed[-1].value == 6
    assert replayed(shell.inputs) == shell.log


def test_it_is_the_answer_changed_last() -> None:
    """Not the one that stands last."""
    shell = at_survey()
    press(shell, "3", "5", "up", "up", "left", "down", "down", "7")
    assert values(shell) == (7, 5)


def test_an_open_question_is_not_passed_over() -> None:
    """On the way past it to Enter, a digit answers nothing."""
    shell = at_survey()
    press(shell, "3", "down", "6")
    assert values(shell) == (3, None)


def test_older_recordings_replay_without_it() -> None:
    """There a digit on Enter did nothing."""
    shell = at_survey(rules=CORRECTING_DIGITS - 1)
    press(shell, "3", "5", "6")
    assert values(shell) == (3, 5)


def at_workload(rules: int = NUMBERS_ON_SCALES) -> FakeShell:
    """Go on to the first scale to more than 9, from 0 to 100 in fives."""
    loaded = load_protocol("every_screen")
    order = tuple(condition.name for condition in loaded.protocol.conditions)
    shell = FakeShell(dataclasses.replace(opened(loaded, order=order), rules=rules))
    shell.go_on_until(
        lambda: isinstance(shell.screen, SurveyScreen) and shell.screen.items[0].high == 100
    )
    shell.t_ns += 1_000_000_000
    return shell


@pytest.mark.parametrize(
    ("keys", "answer"),
    [
        ("3", 30),
        ("35", 35),
        ("36", 35),
        ("05", 5),
        ("100", 100),
        ("10", 10),
        ("0", 0),
        ("356", 60),  # 356 is too much: the last digit begins anew
        (("3", "right", "5"), 50),
    ],
)
def test_numbers_are_typed_on_a_long_scale(keys: tuple[str, ...], answer: int) -> None:
    """A digit alone counts for tens, a second one completes the number; the nearest step counts."""
    shell = at_workload()
    press(shell, *keys)
    assert values(shell)[0] == answer
    assert replayed(shell.inputs) == shell.log


def test_a_digit_two_seconds_later_begins_anew() -> None:
    """Who changes their mind is not taken to go on typing."""
    shell = at_workload()
    press(shell, "3")
    shell.t_ns += SECOND_DIGIT_NS + 1
    press(shell, "5")
    assert values(shell)[0] == 50


def test_a_number_is_not_gone_on_with_on_another_question() -> None:
    """The second digit belongs to the question that it is pressed on."""
    shell = at_workload()
    press(shell, "3", "down", "5")
    assert values(shell)[:2] == (30, 50)


def test_older_recordings_replay_with_tens_alone() -> None:
    """There each digit went for tens."""
    shell = at_workload(rules=NUMBERS_ON_SCALES - 1)
    press(shell, "3", "5")
    assert values(shell)[0] == 50


@pytest.mark.parametrize(
    ("high", "digits", "number"),
    [(10, "3", 3), (10, "10", 10), (10, "13", 3), (50, "35", 35), (89, "9", 9), (90, "9", 90)],
)
def test_only_on_scales_to_ninety_or_more_a_digit_counts_for_tens(
    high: int, digits: str, number: int
) -> None:
    """On one to 10 a 3 is a 3."""
    typed = TypedDigits()
    for digit in digits:
        last = typed.add(0, int(digit), high, 0)
    assert last == number


def test_a_number_out_of_range_is_told_its_range() -> None:
    """Not that nothing was answered."""
    loaded = load_protocol("every_screen")
    order = tuple(condition.name for condition in loaded.protocol.conditions)
    shell = FakeShell(opened(loaded, order=order))
    shell.go_on_until(
        lambda: isinstance(shell.screen, SurveyScreen) and shell.screen.items[0].kind == "number"
    )
    shell.t_ns += 1_000_000_000
    press(shell, "return")
    assert isinstance(shell.screen, SurveyScreen)
    assert shell.screen.reminder == "Please answer this question first."
    press(shell, "3", "return")
    assert shell.screen.reminder.startswith("Type a number from ")
