"""Robots that were stopped: the operator reads it, the events say it, and it replays."""

from __future__ import annotations

import pytest

from fake_shell import FakeShell, replayed
from short_study import opened, short_study
from study.events.events import Deviation, TrialStarted
from study.events.inputs import RobotReported, SessionResumed
from study.screens import FleetScreen


@pytest.fixture
def shell() -> FakeShell:
    """A session in the middle of a trial of the manual condition."""
    made = FakeShell(opened(short_study()))
    made.go_to_trial(3, "manual")
    made.step()
    return made


def report(shell: FakeShell, robot: int, reason: str, *, stopped: bool) -> list[Deviation]:
    """Tell of a robot; return the deviations that follow."""
    text = f"robot {robot + 1}: {reason}"
    given = RobotReported(shell.later(1_000_000), robot, stopped, reason, text, age_ns=5)
    return [event for event in shell.feed(given) if isinstance(event, Deviation)]


def message(shell: FakeShell) -> str:
    """Return what the operator reads after another timestep."""
    shell.step()
    assert isinstance(shell.screen, FleetScreen)
    return shell.screen.message


def test_a_stop_is_read_and_recorded_until_it_is_over(shell: FakeShell) -> None:
    """Each stop is a deviation of its trial; the message stays until the last reason is gone."""
    usual = message(shell)
    trial = next(e.trial_id for e in reversed(shell.events) if isinstance(e, TrialStarted))
    (deviation,) = report(shell, 1, "pose_lost", stopped=True)
    assert (deviation.code, deviation.text, deviation.trial_id) == (
        "robot_stopped",
        "robot 2: pose_lost",
        trial,
    )
    assert message(shell) == "Robot 2 is not seen by motion capture and stands still"
    assert len(report(shell, 1, "battery_flat", stopped=True)) == 1
    assert len(report(shell, 0, "emergency", stopped=True)) == 1
    assert message(shell).startswith("Robot 1 is under an emergency stop and stands still; Robot 2")
    for robot, reason in ((1, "pose_lost"), (0, "emergency")):
        assert report(shell, robot, reason, stopped=False) == []
    assert message(shell) == "Robot 2 has a flat battery and stands still"
    report(shell, 1, "battery_flat", stopped=False)
    assert message(shell) == usual
    assert replayed(shell.inputs) == shell.log


def test_reports_that_fit_nothing_do_nothing(shell: FakeShell) -> None:
    """The end of what never began, and a robot that the fleet does not have."""
    usual = message(shell)
    assert report(shell, 0, "pose_lost", stopped=False) == []
    report(shell, 40, "pose_lost", stopped=True)
    assert message(shell) == usual


def test_it_is_told_in_a_pause_too(shell: FakeShell) -> None:
    """A robot that is lost while the session stands still is recorded; the pause stays."""
    shell.tap("escape")
    screen = shell.screen
    assert len(report(shell, 0, "link_lost", stopped=True)) == 1
    assert type(shell.screen) is type(screen)
    assert replayed(shell.inputs) == shell.log


def test_a_session_that_is_resumed_knows_no_old_stops(shell: FakeShell) -> None:
    """Robots are connected anew then, and all live."""
    report(shell, 0, "link_lost", stopped=True)
    shell.feed(SessionResumed(shell.later(), part=2, after_sequence=1, gap_seconds=1.0))
    shell.tap("return")
    shell.answer_fleet()
    assert "stands still" not in message(shell)


def test_engines_that_are_replaced_are_told_in_one_sentence_at_once(shell: FakeShell) -> None:
    """Before the fleet answers, the tiles of all robots concerned are marked; then no more."""
    usual = message(shell)
    for robot in (0, 1):
        (deviation,) = report(shell, robot, "engine_lost", stopped=True)
        assert deviation.code == "robot_stopped"
    screen = shell.screen
    assert isinstance(screen, FleetScreen)
    assert screen.message == (
        "One moment: robots 1, 2 are being brought back, and all wait for them"
    )
    kinds = [tile.cue.kind if tile.cue else "" for tile in screen.tiles]
    assert kinds[:2] == ["held", "held"]
    assert "held" not in kinds[2:]
    for robot in (0, 1):
        assert report(shell, robot, "engine_lost", stopped=False) == []
    screen = shell.screen
    assert isinstance(screen, FleetScreen)
    assert screen.message == usual
    assert all(tile.cue is None or tile.cue.kind != "held" for tile in screen.tiles)
    assert replayed(shell.inputs) == shell.log
