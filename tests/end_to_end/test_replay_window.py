"""`study replay` in a real window, driven by real keys and clicks."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pygame
import pytest

from cut_sessions import seen_session
from patience import PATIENCE_S, until
from shown_pictures import SIZE, draw_without_window, picture_at
from study.events.events import Switched, TrialStarted
from study.loading import load_protocol
from study.messages import messages_for
from study.recording.parts import read_whole_session
from study.screens import Screen
from study.shell.replay.head import Head
from study.shell.replay.marks import read_marks
from study.shell.replay.picture import Picture
from study.shell.replay.strip import Shown, clock
from x11_driver import Hands, x_server

ROOT = Path(__file__).resolve().parents[2]
Seen = list[tuple[int, Screen]]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Seen]:
    """The smoke study by a simulated participant, and every screen that was shown."""
    return seen_session(tmp_path_factory.mktemp("replayed"), load_protocol("smoke"))


@pytest.fixture
def replay(session: tuple[Path, Seen]) -> Iterator[tuple[Hands, subprocess.Popen[bytes]]]:
    """A replay of it in a window, in the participant's view, standing still."""
    with x_server() as display:
        environment = {**os.environ, "DISPLAY": display, "SDL_VIDEODRIVER": "x11"}
        command = [sys.executable, "-m", "study.commands.main", "replay", str(session[0])]
        process = subprocess.Popen([*command, "--participant-view"], env=environment, cwd=ROOT)
        hands = Hands(display)
        try:
            hands.wait_for_window()
            until(lambda: hands.caption().startswith("Replay of P01, 0:0"))
            yield hands, process
        finally:
            hands.close()
            process.terminate()
            process.wait(PATIENCE_S)


def wait_for_picture(hands: Hands, seen: Seen, t_ns: int) -> None:
    """Wait until the window shows, pixel for pixel, what was shown at a session time."""
    wanted = picture_at(seen, t_ns)
    until(lambda: bool((hands.picture() == wanted).all()))


def times_of(path: Path) -> tuple[list[int], list[int]]:
    """Return when takeovers and trials began, session times."""
    takeovers: list[int] = []
    trials: list[int] = []
    for _, event in read_whole_session(path).records(Switched.topic, TrialStarted.topic):
        if isinstance(event, TrialStarted):
            trials.append(event.t_ns)
        elif isinstance(event, Switched) and event.to_robot >= 0:
            takeovers.append(event.t_ns)
    return takeovers, trials


def test_keys_play_pause_jump_seek_and_quit(
    session: tuple[Path, Seen], replay: tuple[Hands, subprocess.Popen[bytes]]
) -> None:
    """Each key leads to the very picture that the participant saw at that time."""
    path, seen = session
    hands, process = replay
    takeovers, trials = times_of(path)

    # It plays from the beginning, and stands still when it is paused.
    until(lambda: hands.caption() >= "Replay of P01, 0:02")
    hands.tap("space")
    time.sleep(0.3)
    stands = hands.caption(), hands.picture()
    time.sleep(1.3)
    assert hands.caption() == stands[0]
    assert (hands.picture() == stands[1]).all()

    hands.tap("backspace")
    wait_for_picture(hands, seen, 0)
    hands.tap("n")
    wait_for_picture(hands, seen, takeovers[0])
    hands.tap("n")
    wait_for_picture(hands, seen, takeovers[1])
    hands.tap("p")
    wait_for_picture(hands, seen, takeovers[0])
    after = [t for t in trials if t > takeovers[0]]
    for place in range(3):
        hands.tap("t")
        wait_for_picture(hands, seen, after[place])
    hands.tap("r")
    wait_for_picture(hands, seen, after[1])
    hands.tap("left")
    wait_for_picture(hands, seen, after[1] - 5_000_000_000)
    hands.tap("right")
    hands.tap("right")
    wait_for_picture(hands, seen, after[1] + 5_000_000_000)

    # Played 16 times as fast, time goes on faster than the clock on the wall.
    hands.tap("backspace")
    for _ in range(4):
        hands.tap("up")
    hands.tap("space")
    begun = time.monotonic()
    until(lambda: hands.caption() >= "Replay of P01, 0:20")
    assert time.monotonic() - begun < 15
    hands.tap("q")
    assert process.wait(PATIENCE_S) == 0


def test_a_click_on_the_timeline_goes_there(
    session: tuple[Path, Seen], replay: tuple[Hands, subprocess.Popen[bytes]]
) -> None:
    """In the analyst's view; back in the participant's the picture is that of the time clicked."""
    path, seen = session
    hands, process = replay
    hands.tap("space")
    participants = hands.picture()
    hands.tap("v")
    until(lambda: not np.array_equal(hands.picture(), participants))
    marks = read_marks(read_whole_session(path))
    picture = Picture(SIZE, marks, "analyst", messages_for("en"))
    draw_without_window()
    picture.draw(pygame.Surface(SIZE), Shown(Head(), 0, playing=False, speed=1.0))
    height = next(y for y in range(SIZE[1]) if picture.time_at(640, y) is not None) + 10
    for x in (700, 200, 500):
        t_ns = picture.time_at(x, height)
        assert t_ns is not None
        hands.click(x, height)
        until(lambda t_ns=t_ns: hands.caption() == f"Replay of P01, {clock(t_ns)[:-2]}")  # type: ignore[misc]
        hands.tap("v")
        wait_for_picture(hands, seen, t_ns)
        hands.tap("v")
    hands.tap("escape")
    assert process.wait(PATIENCE_S) == 0
