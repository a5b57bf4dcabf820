"""A window whose session ended before its last screen says so, until somebody closes it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pygame
import pytest

from onlooker import Aim, Onlooker
from patience import PATIENCE_S, until
from real_study import close_last_words, real_study
from seated_participant import SIZE
from small_disk import fill, small_disk
from study.enrolment.register import Register
from study.screens import EndScreen, PageScreen, PauseScreen
from study.shell.drawing.renderer import Renderer
from x11_driver import Hands

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a private X server, mounts")

ENDED = EndScreen(
    "The session has ended. Thank you!", "Please tell the experimenter.", achieved=False
)
ERASED = EndScreen(
    "The session has ended. Thank you!",
    "What was recorded of you has been erased. Please tell the experimenter.",
    achieved=False,
)
DECLINED = EndScreen(
    "Thank you for your time.",
    "You do not take part, and nothing was recorded. Please tell the experimenter.",
    achieved=False,
)
FAILED = EndScreen("The session cannot go on.", "Please tell the experimenter.", achieved=False)


def shows(hands: Hands, screen: EndScreen) -> bool:
    """Whether the window shows a screen, pixel by pixel."""
    pygame.font.init()
    surface = pygame.Surface(SIZE)
    Renderer(SIZE).draw(surface, screen, 0)
    wanted = pygame.surfarray.array3d(surface).transpose(1, 0, 2)
    seen = hands.picture()
    return seen.shape == wanted.shape and bool(np.mean(np.abs(seen - wanted.astype(int))) < 0.5)


def paused(onlooker: Onlooker, hands: Hands) -> None:
    """Pause, once the first page is there."""
    until(lambda: isinstance(onlooker.look(), PageScreen))
    hands.tap("escape")
    until(lambda: isinstance(onlooker.look(), PauseScreen))


def test_who_stops_is_thanked(tmp_path: Path) -> None:
    """All is saved and told by then; the key that ended the session does not close the words."""
    folder = tmp_path / "recordings"
    said = tmp_path / "said"
    with said.open("wb") as file, real_study("smoke", folder, said=file) as (hands, study):
        hands.wait_for_window()
        paused(Onlooker(folder), hands)
        hands.tap("q")
        hands.tap("y")
        until(lambda: shows(hands, ENDED))
        until(lambda: "is closed by Enter" in said.read_text())
        assert "Recorded in" in said.read_text()
        assert [path.suffix for path in folder.glob("*.mcap*")] == [".mcap"]
        with Register(folder) as register:
            (known,) = register.participants()
        assert known.state == "dropped"
        time.sleep(0.5)
        assert study.poll() is None
        assert close_last_words(hands, study) == 3


def test_who_has_all_erased_is_told_that_it_is(tmp_path: Path) -> None:
    """The mouse closes the words as well."""
    folder = tmp_path / "recordings"
    with real_study("smoke", folder) as (hands, study):
        hands.wait_for_window()
        paused(Onlooker(folder), hands)
        hands.tap("e")
        hands.tap("y")
        until(lambda: shows(hands, ERASED))
        assert not list(folder.glob("*.mcap*"))
        until(lambda: clicked(hands, study, ERASED))
        assert study.wait() == 3


def clicked(hands: Hands, study: subprocess.Popen[bytes], screen: EndScreen) -> bool:
    """Click on the button; return whether the program has ended."""
    if study.poll() is None:
        hands.click(*Aim(SIZE).at(screen, "confirm"))
    return study.poll() is not None


def test_who_declines_is_thanked(tmp_path: Path) -> None:
    """Ctrl-C closes the window as well, with the same status."""
    with real_study("every_screen", tmp_path / "recordings") as (hands, study):
        hands.wait_for_window()
        time.sleep(1.0)
        hands.tap("n")
        hands.tap("return")
        until(lambda: shows(hands, DECLINED))
        study.send_signal(2)
        assert study.wait(PATIENCE_S) == 3


@pytest.mark.acceptance
def test_a_full_disk_is_told_to_the_participant_too(tmp_path: Path) -> None:
    """That the session cannot go on; the terminal says why before the window is closed."""
    said = tmp_path / "said"
    with (
        small_disk(tmp_path / "small") as folder,
        said.open("wb") as file,
        real_study("smoke", folder, said=file) as (hands, study),
    ):
        hands.wait_for_window()
        until(lambda: isinstance(Onlooker(folder).look(), PageScreen))
        fill(folder)
        until(lambda: shows(hands, FAILED))
        until(lambda: "the disk is full" in said.read_text())
        assert close_last_words(hands, study) == 4
        assert said.read_text().count("Error:") == 1


def test_closing_the_window_needs_no_words(tmp_path: Path) -> None:
    """SIGTERM and the window's own button end the program at once."""
    with real_study("smoke", tmp_path / "recordings") as (hands, study):
        hands.wait_for_window()
        until(lambda: isinstance(Onlooker(tmp_path / "recordings").look(), PageScreen))
        study.terminate()
        assert study.wait(PATIENCE_S) == 3
