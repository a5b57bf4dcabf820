"""How a session opens and how it ends."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from fake_shell import FakeShell
from short_study import opened, short_study
from study.errors import StudyError
from study.events.events import Deviation, SessionEnded, TrialEnded
from study.events.inputs import QuitRequested, TimestepDue
from study.screens import EndScreen
from study.session.rules import TRIAL_OF_END
from study.session.session import Session


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"order": ("manual", "other")}, "the order opened with"),
        ({"order": ()}, "the order opened with"),
        ({"protocol_toml": "format = 1"}, "the recorded protocol"),
        ({"task_json": "{}"}, "no task description"),
        ({"questionnaires_json": "["}, "questionnaires"),
        ({"questionnaires_json": "[]"}, "questionnaires"),
        ({"questionnaires_json": "{}"}, "no questionnaire ease_and_success"),
    ],
)
def test_opening_what_is_no_session_is_refused(changes: dict[str, Any], words: str) -> None:
    """A forged or foreign recording is refused with the reason."""
    first = dataclasses.replace(opened(short_study()), **changes)
    with pytest.raises(StudyError, match=words):
        Session().handle(first)


def test_first_input_opens() -> None:
    """Nothing can come before SessionOpened."""
    with pytest.raises(StudyError, match="not SessionOpened"):
        Session().handle(TimestepDue(0, 0))


def test_older_recordings_end_early_in_no_trial() -> None:
    """As they were recorded; in a stage without a trial there is none in newer ones either."""
    for rules, at_trial in ((TRIAL_OF_END - 1, True), (TRIAL_OF_END, False)):
        shell = FakeShell(dataclasses.replace(opened(short_study()), rules=rules))
        if at_trial:
            shell.go_to_trial(2)
            shell.step()
        shell.feed(QuitRequested(shell.later(), "window closed"))
        ends = [event for event in shell.events if isinstance(event, Deviation)]
        assert ends[-1].trial_id == -1


@pytest.mark.parametrize("key", ["return", "escape"])
def test_last_screen_is_closed_by_enter_or_escape(key: str) -> None:
    """Either key ends the session, complete; its screen can still be asked for."""
    shell = FakeShell(opened(short_study()))
    shell.go_on_until(lambda: isinstance(shell.screen, EndScreen))
    shell.key(key)
    last = shell.events[-1]
    assert isinstance(last, SessionEnded)
    assert last.complete
    assert isinstance(shell.session.screen, EndScreen)


def test_closing_the_window_on_the_last_screen_is_no_deviation() -> None:
    """Everything has been passed by then."""
    shell = FakeShell(opened(short_study()))
    shell.go_on_until(lambda: isinstance(shell.screen, EndScreen))
    shell.feed(QuitRequested(shell.later(), "window closed"))
    assert shell.session.complete


def test_stopping_in_a_trial_closes_it_as_incomplete() -> None:
    """Escape, Q, Y: the trial is broken off, and the deviation says where."""
    shell = FakeShell(opened(short_study()))
    shell.go_to_trial(2)
    shell.step()
    for key in ("escape", "q"):
        shell.tap(key)
    assert not shell.finished
    trial, deviation, ended = shell.tap("y")
    assert isinstance(trial, TrialEnded)
    assert (trial.complete, trial.timesteps) == (False, 1)
    assert isinstance(deviation, Deviation)
    assert deviation.code == "ended_early"
    assert "phase 2" in deviation.text
    assert deviation.trial_id == trial.trial_id
    assert isinstance(ended, SessionEnded)
    assert not ended.complete
