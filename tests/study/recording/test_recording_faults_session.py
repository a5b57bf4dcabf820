"""What the session makes of a recording that is interrupted and restored."""

from __future__ import annotations

import dataclasses
from typing import Any

from event_books import check_books
from fake_shell import FakeShell, replayed
from short_study import opened, short_study
from study.events.events import Deviation, Event, Paused, Resumed, StageEntered, Timestep
from study.events.inputs import QuitRequested, RecordingInterrupted, SessionResumed
from study.screens import FleetScreen, PauseScreen
from study.session.rules import STALLS_TOLD

SECOND = 1_000_000_000


def shell_in_trial() -> FakeShell:
    shell = FakeShell(opened(short_study()))
    shell.go_to_trial(3, "manual")
    shell.step()
    return shell


def of_type(events: list[Event], kind: type[Event]) -> list[Any]:
    return [event for event in events if isinstance(event, kind)]


def reason(shell: FakeShell) -> str:
    assert isinstance(shell.screen, PauseScreen)
    return shell.screen.reason


def test_an_interruption_pauses_until_it_is_restored_and_confirmed() -> None:
    """The pause says why; Enter goes on only once the recording works again."""
    shell = shell_in_trial()
    steps = len(of_type(shell.events, Timestep))
    shell.feed(RecordingInterrupted(shell.later(), "the writer process ended unexpectedly"))
    assert shell.pace == 0
    assert "interrupted" in reason(shell)
    shell.key("return")
    assert isinstance(shell.screen, PauseScreen)
    shell.restore()
    assert "works again" in reason(shell)
    (deviation,) = of_type(shell.events, Deviation)
    trial_id = of_type(shell.events, Timestep)[-1].trial_id
    assert (deviation.code, deviation.trial_id) == ("recording_interrupted", trial_id)
    assert deviation.text == "the writer process ended unexpectedly; recorded in part 2 from here"
    assert of_type(shell.events, Resumed) == []
    shell.key("return")
    assert isinstance(shell.screen, FleetScreen)
    assert shell.pace > 0
    shell.step()
    assert len(of_type(shell.events, Timestep)) == steps + 1
    assert [event.reason for event in of_type(shell.events, Paused)] == ["recording interrupted"]
    shell.key("escape")
    assert reason(shell) == "Paused"
    assert replayed(shell.inputs) == shell.log


def test_a_part_that_goes_on_is_told_from_one_that_begins() -> None:
    """A writer that only stood still began no part, whichever it was; older rules knew one text."""
    shell = shell_in_trial()
    for part in (1, 2, 2):
        shell.interrupt()
        shell.later(3 * SECOND - 1_000_000)
        shell.restore(part)
    went_on = "made up; 3.0 s later all records were on disk: nothing was lost"
    texts = [event.text for event in of_type(shell.events, Deviation)]
    assert texts == [went_on, "made up; recorded in part 2 from here", went_on]
    assert replayed(shell.inputs) == shell.log
    older = FakeShell(dataclasses.replace(opened(short_study()), rules=STALLS_TOLD - 1))
    older.interrupt()
    older.restore(1)
    (deviation,) = of_type(older.events, Deviation)
    assert deviation.text == "made up; recorded in part 1 from here"


def test_the_part_that_a_resumed_session_goes_on_in_is_known() -> None:
    """Its writer may stand still too."""
    shell = shell_in_trial()
    shell.feed(SessionResumed(shell.later(), 3, after_sequence=1, gap_seconds=1.0))
    shell.interrupt()
    shell.restore(3)
    texts = [event.text for event in of_type(shell.events, Deviation)]
    assert "nothing was lost" in texts[-1]


def test_an_interruption_in_a_pause_is_part_of_that_pause() -> None:
    """One pause, one going on; the screen says what happened."""
    shell = shell_in_trial()
    shell.key("escape")
    shell.interrupt()
    shell.restore()
    assert "works again" in reason(shell)
    shell.key("return")
    assert len(of_type(shell.events, Paused)) == len(of_type(shell.events, Resumed)) == 1
    assert isinstance(shell.screen, FleetScreen)


def test_stopping_while_interrupted_ends_the_session() -> None:
    """Who does not want to wait may stop, and so may the experimenter."""
    by_key, by_signal = shell_in_trial(), shell_in_trial()
    by_key.interrupt()
    by_key.key("q")
    by_key.key("y")
    by_signal.interrupt()
    by_signal.feed(QuitRequested(by_signal.later(), "SIGTERM"))
    for shell in (by_key, by_signal):
        assert shell.finished
        check_books(shell.events, short_study().description.idle_action)


def test_every_stage_can_be_interrupted() -> None:
    """Fits and the robots' own trials stand still too, and the session is passed to its end."""
    shell = FakeShell(opened(short_study()))
    entered = interruptions = 0
    while not shell.finished:
        # A stage that has nothing to do is entered together with the one after it.
        stages = len(of_type(shell.events, StageEntered))
        if stages > entered:
            entered = stages
            interruptions += 1
            shell.interrupt()
        shell.help()
    assert shell.session.complete
    codes = [event.code for event in of_type(shell.events, Deviation)]
    assert codes == ["recording_interrupted"] * interruptions
    check_books(shell.events, short_study().description.idle_action)
    assert replayed(shell.inputs) == shell.log


def test_a_restoring_without_an_interruption_is_nothing() -> None:
    """It leaves no trace in the events."""
    shell = shell_in_trial()
    assert shell.restore() == ()
    assert isinstance(shell.screen, FleetScreen)
