"""A stand-in for a participant: watches the growing recording, answers with real events.

It knows where the study is from the recording alone, as an onlooker would.
"""

from __future__ import annotations

import random
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import pygame

from patience import PATIENCE_S
from study.errors import StudyError
from study.events.events import (
    Deviation,
    FitApplied,
    SessionEnded,
    StageEntered,
    TrialEnded,
    TrialStarted,
)
from study.recording.reader import read_recording
from study.screens import Screen, SurveyItem, SurveyScreen
from study.shell.drawing.renderer import Renderer
from x11_driver import Hands

TOPICS = (
    "event/stage_entered",
    "event/trial_started",
    "event/trial_ended",
    "event/fit_applied",
    "event/session_ended",
    "event/deviation",
)


PHASE_FOUR = 4
"""The robots drive on their own: there is nothing to press."""


@dataclass(frozen=True)
class Progress:
    """How far a session has got.

    Attributes:
        stage: the present one, if there is one yet.
        running: whether its trial runs.
        interruptions: how often the recording was interrupted, which pauses the session.
        ended: whether the session ended.
    """

    stage: StageEntered | None = None
    running: bool = False
    interruptions: int = 0
    ended: bool = False


def progress_of(parts: list[Path]) -> Progress:
    """Return how far a session has got.

    Args:
        parts: its files in order. A record sent again is in two of them, which changes nothing
            but the interruptions: those are told apart by their times.
    """
    stage, running, ended = None, False, False
    interrupted: set[int] = set()
    for part in parts:
        for _, event in read_recording(part).records(*TOPICS):
            if isinstance(event, StageEntered):
                stage, running = event, False
            elif isinstance(event, TrialStarted):
                running = True
            elif isinstance(event, TrialEnded | FitApplied):
                running = False
            elif isinstance(event, SessionEnded):
                ended = True
            elif isinstance(event, Deviation) and event.code == "recording_interrupted":
                interrupted.add(event.t_ns)
    return Progress(stage, running, len(interrupted), ended)


class Participant:
    """Goes through a whole session by keys and mouse.

    Args:
        hands: what presses.
        folder: where the recording grows.
        study: the running program.
        mouse: whether surveys and pages are answered by clicks where that is possible.
        seed: of the choices made.
        part: which part of the session is being recorded.
    """

    def __init__(
        self,
        hands: Hands,
        folder: Path,
        study: subprocess.Popen[bytes],
        *,
        mouse: bool,
        seed: int,
        part: int = 1,
    ) -> None:
        self._hands = hands
        self._folder = folder
        self._study = study
        self._mouse = mouse
        self._first_file = part - 1
        self._seen: dict[Path, int] = {}
        self._place_in_study = Progress()
        self._interruptions = 0
        self._random = random.Random(seed)
        self._renderer: Renderer | None = None

    def _look(self) -> Progress:
        """Read the parts again if they have grown: when a writer fails there is more than one."""
        try:
            files = sorted(self._folder.glob("*.mcap*"))[self._first_file :]
            sizes = {path: path.stat().st_size for path in files}
            if sizes != self._seen:
                self._place_in_study = progress_of(list(sizes))
                self._seen = sizes
        except (StudyError, FileNotFoundError):
            pass  # A file is being made or moved into place.
        return self._place_in_study

    def run(self, timeout_s: float) -> None:
        """Go through to the end."""
        deadline = time.monotonic() + timeout_s
        self._hands.wait_for_window()
        while time.monotonic() < deadline and self._study.poll() is None:
            now = self._look()
            stage, running = now.stage, now.running
            if now.ended or stage is None:
                time.sleep(0.05)
            elif now.interruptions > self._interruptions:
                self._interruptions = now.interruptions
                self._hands.tap("return")
            elif stage.kind == "pages" and stage.name == "thanks":
                self._hands.key("return", down=True)
                self._wait_for_end(PATIENCE_S)
            elif stage.kind == "trial" and running:
                self._drive(stage)
            elif stage.kind == "survey":
                self._answer()
            elif stage.kind in ("pages", "trial", "reveal") and stage.phase < PHASE_FOUR:
                self._hands.tap("return")
                time.sleep(0.12)
            else:
                time.sleep(0.05)
        assert self._study.poll() is not None, "the session did not end in time"

    def _wait_for_end(self, seconds: float) -> None:
        deadline = time.monotonic() + seconds
        while self._study.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)

    def _drive(self, stage: StageEntered) -> None:
        if stage.phase in (2, 3) and self._random.random() < 0.3:
            self._hands.tap(self._random.choice(["1", "2", "3", "4", "tab"]))
        self._hands.tap(
            self._random.choice(["up", "up", "up", "left", "right", "down"]),
            hold_s=self._random.choice([0.02, 0.15, 0.3]),
        )

    def _answer(self) -> None:
        if self._mouse:
            for target in ("answer:q1:5", "answer:q2:2", "confirm"):
                self._hands.click(*self._place(target))
                time.sleep(0.1)
        else:
            # A questionnaire is deaf to keys for its first half second.
            time.sleep(0.6)
            for key in (self._random.choice("1234567"), self._random.choice("1234567"), "return"):
                self._hands.tap(key)
        time.sleep(0.3)

    def _place(self, target: str) -> tuple[int, int]:
        """Find where a target is drawn, as an eye would."""
        if self._renderer is None:
            pygame.font.init()
            self._renderer = Renderer((1280, 960))
        return find_target(self._renderer, survey_screen(), target)


def survey_screen() -> SurveyScreen:
    """Return a survey like the study's, to find its answers' places."""
    labels = ((1, "Strongly Disagree"), (4, "Neither Disagree nor Agree"), (7, "Strongly Agree"))
    texts = {
        "q1": "It was easy to guide the robots to their goals",
        "q2": "I was successful at guiding the robots",
    }
    return SurveyScreen(
        header_left="Part 3 of 4, block 1 of 2: finished",
        header_right="Questions 1 to 2",
        title="About the block you just finished",
        prompt="How much do you agree with each sentence?",
        items=tuple(
            SurveyItem(item=item, text=text, low=1, high=7, labels=labels, value=None)
            for item, text in texts.items()
        ),
        focus=0,
        complete=False,
        reminder="",
    )


def find_target(renderer: Renderer, screen: Screen, target: str) -> tuple[int, int]:
    """Return the middle of the pixels that hit a target."""
    hits = [
        (x, y)
        for y in range(4, 960, 8)
        for x in range(4, 1280, 8)
        if renderer.hit(screen, x, y) == target
    ]
    assert hits, f"nothing on the screen hits {target}"
    return hits[len(hits) // 2]
