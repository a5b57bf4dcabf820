"""Keys meant for robots answer no question: a questionnaire is deaf to them at first."""

from __future__ import annotations

import dataclasses

import pytest

from fake_shell import FakeShell, replayed
from short_study import opened
from study.events.events import QuestionAnswered
from study.events.inputs import KeyChanged, PointerPressed, TextTyped
from study.events.participant_events import AnswerChanged
from study.loading import LoadedProtocol, load_protocol
from study.screens import SurveyScreen
from study.session.rules import DEAD_TIME

ORDER = ("manual", "assisted", "suggested", "switched_at_random")
HALF_SECOND = 500_000_000
DRIVING_KEYS = ("left", "right", "up", "down", "tab", "3", "return")


@pytest.fixture(scope="module")
def every_screen() -> LoadedProtocol:
    """The shipped protocol."""
    return load_protocol("every_screen")


def at_survey(loaded: LoadedProtocol, rules: int = DEAD_TIME) -> tuple[FakeShell, int]:
    """Go on to the first survey after a block; return the session time of its first picture."""
    shell = FakeShell(dataclasses.replace(opened(loaded, order=ORDER), rules=rules))
    shell.go_on_until(
        lambda: isinstance(shell.screen, SurveyScreen) and "block" in shell.screen.header_left
    )
    return shell, shell.inputs[-1].t_ns


def changes(shell: FakeShell) -> int:
    """Return how many changes of an answer were recorded."""
    return sum(isinstance(event, AnswerChanged | QuestionAnswered) for event in shell.events)


def test_keys_of_the_first_half_second_answer_nothing(every_screen: LoadedProtocol) -> None:
    """Whatever drives robots leaves the questions and the focus as they are."""
    shell, shown = at_survey(every_screen)
    screen, before = shell.screen, changes(shell)
    for number, key in enumerate(DRIVING_KEYS):
        shell.feed(KeyChanged(shown + number, key, down=True, poll_gap_ns=0))
    shell.feed(KeyChanged(shown + HALF_SECOND - 1, "4", down=True, poll_gap_ns=0))
    shell.feed(TextTyped(shown + HALF_SECOND - 1, "w"))
    assert shell.session.screen == screen
    assert changes(shell) == before
    assert replayed(shell.inputs) == shell.log


def test_keys_answer_from_then_on(every_screen: LoadedProtocol) -> None:
    """The half second over, a digit is an answer."""
    shell, shown = at_survey(every_screen)
    before = changes(shell)
    shell.feed(KeyChanged(shown + HALF_SECOND, "4", down=True, poll_gap_ns=0))
    assert changes(shell) == before + 1


def test_the_pointer_answers_at_once(every_screen: LoadedProtocol) -> None:
    """Robots are driven by keys: a click on an answer is meant."""
    shell, shown = at_survey(every_screen)
    before = changes(shell)
    assert isinstance(shell.screen, SurveyScreen)
    item = shell.screen.items[0]
    target = f"answer:{item.item}:{item.high}"
    shell.feed(PointerPressed(shown + 1, 1.0, 2.0, target, poll_gap_ns=0))
    assert changes(shell) == before + 1


def test_older_recordings_replay_without_it(every_screen: LoadedProtocol) -> None:
    """What a key answered at once still follows from recordings made before."""
    shell, shown = at_survey(every_screen, rules=DEAD_TIME - 1)
    before = changes(shell)
    shell.feed(KeyChanged(shown + 1, "4", down=True, poll_gap_ns=0))
    assert changes(shell) == before + 1
