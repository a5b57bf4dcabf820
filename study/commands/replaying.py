"""Watching a recording again: in a window, or as a video."""

from __future__ import annotations

import dataclasses
import os
import re
from contextlib import closing
from pathlib import Path

import pygame
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from study.commands.terminal import console, errors
from study.enrolment.importing import note_export
from study.errors import RecordingError, StudyError
from study.recording.parts import SessionRecording, read_whole_session
from study.session.opening import texts_of
from study.shell.replay.camera import Camera
from study.shell.replay.marks import Marks, read_marks
from study.shell.replay.picture import Picture, View, size_for
from study.shell.replay.player import SPEEDS, Player
from study.shell.replay.recorded_pictures import RecordedPictures
from study.shell.replay.tape import Tape
from study.shell.replay.video import Cut, check_target, write_video
from study.shell.replay.viewer import Viewer
from study.shell.window import check_ui_scale

SECOND = 1_000_000_000
MINUTE_S = 60.0
_TIME = re.compile(r"(?:(?P<minutes>\d{1,5}):)?(?P<seconds>\d{1,6}(?:\.\d{1,9})?)")


@dataclasses.dataclass(frozen=True, slots=True)
class Wish:
    """What is to be seen of a recording, and how.

    Attributes:
        view: the participant's screen alone, or with timeline and scores.
        trial: number of the fleet run in the session, from 0; None for all.
        first, last: session times as given, "12:34.5" or seconds; empty for the ends.
        size: of the window or video, pixels; None for what suits.
        speed: session seconds a second.
        rate: frames a second of a video.
        ui_scale: that of the participant's window.
    """

    view: View
    trial: int | None = None
    first: str = ""
    last: str = ""
    size: tuple[int, int] | None = None
    speed: float = 1.0
    rate: int = 30
    ui_scale: float = 1.0


def watch(file: Path, wish: Wish) -> None:
    """Open a recording in a window and play it until the window is closed.

    Raises:
        StudyError: it cannot be read or replayed, there is no display, or the wish cannot be met.
    """
    if wish.speed not in SPEEDS:
        known = ", ".join(f"{speed:g}" for speed in SPEEDS)
        raise StudyError(f"a speed of {wish.speed:g}", f"Give one of {known}.")
    recording, marks, tape = _opened(file, wish)
    first_ns, _ = _span(wish, marks)
    player = Player(marks, first_ns, wish.speed)
    messages = texts_of(marks.language)
    with closing(Camera(RecordedPictures(recording))) as camera:
        Viewer(tape, marks, player, wish.view, messages, wish.size, wish.ui_scale, camera).run()
    _tell_substitute(camera)
    _tell_end(tape)


def film(file: Path, wish: Wish, target: Path) -> bool:
    """Write a recording, or a part of it, as a video.

    Returns:
        Whether the recording was whole.

    Raises:
        StudyError: as `watch`; or the video cannot be written.
    """
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    pygame.font.init()
    recording, marks, tape = _opened(file, wish)
    first_ns, last_ns = _span(wish, marks)
    cut = Cut(first_ns, last_ns, wish.rate, wish.speed)
    width, height = wish.size or size_for(wish.view, marks, first_ns)
    # Colours are stored for two pixels by two.
    size = (width, height) if wish.size else (width + width % 2, height + height % 2)
    check_target(target, size)
    messages = texts_of(marks.language)
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    with (
        closing(Camera(RecordedPictures(recording))) as camera,
        Progress(*columns, TimeRemainingColumn(), console=errors, transient=True) as progress,
    ):
        picture = Picture(size, marks, wish.view, messages, wish.ui_scale, camera)
        bar = progress.add_task("Writing the video", total=cut.frames)
        write_video(tape, picture, cut, target, lambda done: progress.update(bar, completed=done))
    try:
        note_export(file, target)
    except StudyError as error:
        errors.print(f"[yellow]The register does not know of this file:[/] {escape(str(error))}")
    _tell_substitute(camera)
    console.print(
        f"{cut.frames} frames of {size[0]}x{size[1]} pixels written to {escape(str(target))}"
    )
    _tell_end(tape)
    return recording.complete and not tape.difference


def _tell_substitute(camera: Camera) -> None:
    """Say if tiles showed something else than the participant saw."""
    if camera.unusable:
        errors.print(
            "[yellow]Pictures that tiles showed are not in the recording, and could not be taken "
            f"again here:[/] {escape(camera.unusable)}\n  Tiles show the map from above instead, "
            "or that there is no picture."
        )


def _opened(file: Path, wish: Wish) -> tuple[SessionRecording, Marks, Tape]:
    """Open a recording, and say what is missing of it."""
    check_ui_scale(wish.ui_scale)
    recording = read_whole_session(file)
    try:
        marks, tape = read_marks(recording), Tape(recording)
    except RecordingError as error:
        # What a damaged record said is refused by the session, which knows no file.
        raise RecordingError(f"{file}: {error.message}", error.hint) from error
    if len(recording.parts) > 1:
        console.print(f"The session has {len(recording.parts)} parts.")
    if not recording.complete:
        errors.print("[bold yellow]Not whole:[/] what can be read is shown, but")
        for problem in recording.problems or ("the recording was not finished.",):
            errors.print(f"  {escape(problem)}")
    return recording, marks, tape


def _tell_end(tape: Tape) -> None:
    if tape.difference:
        errors.print(f"[bold yellow]Not to its end:[/] {escape(tape.difference)}")


def _span(wish: Wish, marks: Marks) -> tuple[int, int]:
    """Return from when to when the wish is, session times, ns.

    Raises:
        StudyError: there is no such trial or time.
    """
    first_ns, last_ns = 0, marks.last_ns
    if wish.trial is not None:
        trials = marks.of_kind("trial")
        found = next((trial for trial in trials if trial.trial_id == wish.trial), None)
        if found is None:
            there = f"{trials[0].trial_id} to {trials[-1].trial_id}" if trials else "none"
            raise StudyError(
                f"no trial {wish.trial} in the session",
                f"Trials are numbered as in the tables (trial_id); there are: {there}.",
            )
        first_ns, last_ns = found.first_ns, found.last_ns
    first_ns = _time_of(wish.first) if wish.first else first_ns
    last_ns = min(marks.last_ns, _time_of(wish.last)) if wish.last else last_ns
    if not 0 <= first_ns < max(last_ns, 1):
        raise StudyError(
            f"nothing from {first_ns / SECOND:g} s to {last_ns / SECOND:g} s",
            f"The session lasts {marks.last_ns / SECOND:g} s; give --from before --to.",
        )
    return first_ns, last_ns


def _time_of(given: str) -> int:
    """Return "12:34.5", or seconds, in ns.

    Raises:
        StudyError: it is no time.
    """
    match = _TIME.fullmatch(given.strip())
    if match is None or (match["minutes"] and float(match["seconds"]) >= MINUTE_S):
        raise StudyError(f'time "{given}"', 'Give minutes and seconds, "12:34.5", or seconds.')
    return round((int(match["minutes"] or 0) * 60 + float(match["seconds"])) * SECOND)
