"""What the experimenter asks for at the console, as the session takes it."""

from __future__ import annotations

import pytest

from fake_shell import FakeShell, replayed
from short_study import opened, short_study
from study.events.events import (
    Deviation,
    FitApplied,
    Paused,
    Resumed,
    SessionEnded,
    Timestep,
    TrialEnded,
    TrialStarted,
)
from study.events.experimenter_records import ExperimenterNoted
from study.events.inputs import FocusChanged
from study.screens import FleetScreen, PauseScreen, WaitScreen

HELD = "The experimenter has paused the session"


@pytest.fixture
def shell() -> FakeShell:
    """A session in its first manual trial."""
    made = FakeShell(opened(short_study()), 3)
    made.go_to_trial(3, "manual")
    return made


def pause_screen(shell: FakeShell) -> PauseScreen:
    assert isinstance(shell.screen, PauseScreen)
    assert shell.pace == 0
    return shell.screen


def running_trial(shell: FakeShell) -> int:
    return next(e.trial_id for e in reversed(shell.events) if isinstance(e, TrialStarted))


def test_a_pause_holds_until_the_experimenter_ends_it(shell: FakeShell) -> None:
    """Calm screen, no clock; no key and no click goes on; then the trial does, where it was."""
    shell.step()
    before, trial = shell.pace, running_trial(shell)
    paused, deviation = sorted(shell.command("pause"), key=lambda event: event.topic, reverse=True)
    assert isinstance(paused, Paused)
    assert paused.reason == "experimenter"
    assert isinstance(deviation, Deviation)
    assert (deviation.code, deviation.trial_id) == ("experimenter_paused", trial)
    screen = pause_screen(shell)
    assert (screen.reason, screen.can_go_on) == (HELD, False)
    for key in ("return", "escape", "up", "y", "tab"):
        assert shell.tap(key) == ()
    assert shell.point("continue") == ()
    assert shell.due() == ()
    assert shell.command("pause") == ()
    assert pause_screen(shell) == screen
    (resumed,) = shell.command("resume")
    assert isinstance(resumed, Resumed)
    assert resumed.paused_ns == resumed.t_ns - paused.t_ns
    assert isinstance(shell.screen, FleetScreen)
    assert shell.pace == before
    assert [e.timestep for e in shell.step() if isinstance(e, Timestep)] == [1]
    assert replayed(shell.inputs) == shell.log


def test_the_participant_may_still_stop(shell: FakeShell) -> None:
    """Asked twice, as in any pause; calling it off leads back to the experimenter's pause."""
    shell.command("pause")
    shell.tap("q")
    assert pause_screen(shell).confirm_stop
    shell.tap("return")
    assert not pause_screen(shell).confirm_stop
    assert pause_screen(shell).reason == HELD
    shell.tap("q")
    shell.tap("y")
    assert isinstance(shell.events[-1], SessionEnded)
    assert shell.events[-1].reason == "stopped by the participant"


def test_a_pause_of_the_participant_is_given_back(shell: FakeShell) -> None:
    """Held on top of a lost focus, a session does not go on by the experimenter alone."""
    shell.feed(FocusChanged(shell.later(), focused=False))
    assert not any(isinstance(event, Paused) for event in shell.command("pause"))
    assert not pause_screen(shell).can_go_on
    assert shell.command("resume") == ()
    assert pause_screen(shell).can_go_on
    (resumed,) = shell.key("return")
    assert isinstance(resumed, Resumed)


def test_an_interruption_of_the_recording_outlasts_it(shell: FakeShell) -> None:
    """Whichever ends last: what the participant saw of saving, they end themselves."""
    shell.command("pause")
    shell.interrupt()
    assert "Saving" in pause_screen(shell).reason
    assert shell.command("resume") == ()
    assert shell.tap("return") == ()
    shell.restore()
    assert pause_screen(shell).can_go_on
    assert any(isinstance(event, Resumed) for event in shell.tap("return"))


def test_a_fit_that_ends_meanwhile_takes_effect_behind_the_pause(shell: FakeShell) -> None:
    """It holds where the participant cannot pause, too; what follows waits."""
    shell.go_on_until(lambda: shell.fit is not None and isinstance(shell.screen, WaitScreen))
    shell.command("pause")
    assert pause_screen(shell).reason == HELD
    assert any(isinstance(event, FitApplied) for event in shell.answer_fit("completed"))
    assert pause_screen(shell).reason == HELD
    shell.command("resume")
    shell.go_on_until(lambda: shell.finished)
    assert shell.session.complete
    assert replayed(shell.inputs) == shell.log


def test_a_note_knows_where_it_was_taken(shell: FakeShell) -> None:
    """Trial and stage; it changes nothing, even in a pause; an empty one is none."""
    screen, text = shell.screen, "coughs; <b>=1+1</b> \N{ROBOT FACE}"
    (noted,) = shell.command("annotate", text)
    assert isinstance(noted, ExperimenterNoted)
    assert (noted.text, noted.trial_id) == (text, running_trial(shell))
    assert shell.screen is screen
    assert shell.command("annotate") == ()
    shell.command("pause")
    (again,) = shell.command("annotate", "called away")
    assert isinstance(again, ExperimenterNoted)
    assert again.stage == noted.stage
    pause_screen(shell)


def test_ending_early_keeps_the_reason(shell: FakeShell) -> None:
    """The trial is closed as incomplete, the deviation says why and where."""
    shell.step()
    ended = shell.command("end", "fire drill")
    assert [type(event) for event in ended] == [TrialEnded, Deviation, SessionEnded]
    trial, deviation, last = ended
    assert isinstance(trial, TrialEnded)
    assert not trial.complete
    assert isinstance(deviation, Deviation)
    assert deviation.code == "ended_early"
    assert "fire drill" in deviation.text
    assert isinstance(last, SessionEnded)
    assert last.reason == "ended by the experimenter: fire drill"
    assert not last.complete
    assert shell.command("annotate", "too late") == ()


def test_unknown_commands_do_nothing(shell: FakeShell) -> None:
    """A recording of a later version may hold them."""
    assert shell.command("dance", "tango") == ()
    assert shell.command("resume") == ()
    assert isinstance(shell.screen, FleetScreen)
