"""Consent in a real window: nothing is written before it, and what was recorded can be erased."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from onlooker import Aim, Onlooker
from patience import PATIENCE_S, until
from real_study import close_last_words
from seated_participant import SIZE, SeatedParticipant
from study.enrolment.not_taking_part import COUNTS
from study.enrolment.register import Register
from study.events.events import SessionStarted
from study.events.participant_events import ConsentGiven
from study.loading import load_protocol
from study.recording.enrolled import TOMBSTONES, tombstones
from study.recording.reader import read_recording
from study.recording.register_folders import FILE_NAME
from study.screens import PauseScreen
from x11_driver import Hands, x_server

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def seated(folder: Path) -> Iterator[tuple[Hands, subprocess.Popen[bytes]]]:
    """Start a session that asks for consent, with a participant's hands at its window."""
    with x_server() as display:
        environment = {
            **os.environ,
            "DISPLAY": display,
            "SDL_VIDEODRIVER": "x11",
            "SDL_AUDIODRIVER": "dummy",
        }
        command = [sys.executable, "-m", "study.commands.main", "run", "every_screen", "-p", "P01"]
        study = subprocess.Popen([*command, "-o", str(folder)], env=environment, cwd=ROOT)
        hands = Hands(display)
        try:
            hands.wait_for_window()
            # The first screen is drawn and keys are looked at soon after the window is there.
            time.sleep(1.0)
            yield hands, study
        finally:
            study.terminate()
            study.wait(PATIENCE_S)
            hands.close()


def recordings(folder: Path) -> list[Path]:
    """Return the recordings there are, those in the making too."""
    return sorted(folder.glob("*.mcap*"))


def counts(folder: Path) -> object:
    """Return what is counted of those who do not take part."""
    return json.loads((folder / COUNTS).read_text())


def check_tombstone(folder: Path) -> None:
    """Check that pseudonym, time and a count are all that is left of who had all erased."""
    assert sorted(path.name for path in folder.iterdir()) == [COUNTS, FILE_NAME, TOMBSTONES]
    assert counts(folder) == {"every_screen": {"declined": 0, "erased": 1}}
    assert list(tombstones(folder)["every_screen"]) == ["P01"]
    with Register(folder) as register:
        (known,) = register.participants()
    assert (known.state, known.order) == ("withdrawn", ())


def test_declining_leaves_a_count_and_nothing_else(tmp_path: Path) -> None:
    """No recording, no name: one more who declined."""
    folder = tmp_path / "recordings"
    with seated(folder) as (hands, study):
        assert not recordings(folder)
        hands.tap("n")
        hands.tap("Return")
        assert close_last_words(hands, study) == 3
    assert sorted(path.name for path in folder.iterdir()) == [COUNTS, FILE_NAME]
    assert counts(folder) == {"every_screen": {"declined": 1, "erased": 0}}
    assert not any(b"P01" in path.read_bytes() for path in folder.iterdir())


def test_a_recording_opens_with_consent_and_can_be_erased(tmp_path: Path) -> None:
    """It begins once the text is agreed to; Escape, E and Y remove it and leave a count."""
    folder = tmp_path / "recordings"
    with seated(folder) as (hands, study):
        assert not recordings(folder)
        # Enter alone confirms nothing: neither answer is preselected.
        hands.tap("Return")
        hands.tap("y")
        assert not recordings(folder)
        hands.tap("Return")
        until(lambda: bool(recordings(folder)) and consented(recordings(folder)[0]))
        for key in ("Escape", "e", "y"):
            hands.tap(key)
        assert close_last_words(hands, study) == 3
    check_tombstone(folder)


def test_the_mouse_alone_agrees_and_has_all_erased(tmp_path: Path) -> None:
    """Only the pause itself is asked for by a key; both questions of erasing are clicked."""
    folder = tmp_path / "recordings"
    with seated(folder) as (hands, study):
        onlooker = Onlooker(folder)
        participant = SeatedParticipant(hands, onlooker, study, mouse=True)
        participant.agree(load_protocol("every_screen"))
        hands.tap("escape")
        for asked in (False, True):
            hands.click(*Aim(SIZE).at(paused(onlooker, asked=asked), "erase"))
        assert close_last_words(hands, study) == 3
    check_tombstone(folder)


def paused(onlooker: Onlooker, *, asked: bool) -> PauseScreen:
    """Wait for a pause that asks, or does not yet ask, if erasing is meant; return it."""

    def seen() -> bool:
        screen = onlooker.look()
        return isinstance(screen, PauseScreen) and screen.confirm_erase == asked

    until(seen)
    # The picture follows within a frame.
    time.sleep(0.3)
    screen = onlooker.look()
    assert isinstance(screen, PauseScreen)
    return screen


def consented(path: Path) -> bool:
    """Whether a recording in the making holds the consent to it, before any stage."""
    if not path.stat().st_size:
        return False
    topics = ("event/session_started", "event/consent_given", "event/stage_entered")
    found = [record for _, record in read_recording(path).records(*topics)]
    return [type(record) for record in found[:2]] == [SessionStarted, ConsentGiven]
