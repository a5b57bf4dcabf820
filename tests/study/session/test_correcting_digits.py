"""A digit pressed where all is answered corrects the answer given last."""

from __future__ import annotations

import dataclasses

from fake_shell import FakeShell, replayed
from short_study import opened, short_study
from study.events.participant_events import AnswerChanged
from study.screens import SurveyScreen
from study.session.rules import CORRECTING_DIGITS


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
