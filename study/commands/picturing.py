"""Pictures of the screens of a simulated session."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pygame

from study.commands.recorded_scorers import recorded_weights
from study.commands.simulating import simulated_assignments
from study.commands.unrecorded import run_unrecorded
from study.errors import StudyError
from study.loading import LoadedProtocol
from study.messages import Messages
from study.screens import FleetScreen, PageScreen, PauseScreen, Screen, SurveyScreen, WaitScreen
from study.session.standstill import HELD
from study.shell.drawing.pictures import Pictures
from study.shell.drawing.renderer import Renderer
from study.shell.fitting import InlineFitter
from study.shell.virtual_loop import VirtualClock

MOMENT = 67
"""Timestep of a trial that is pictured; the last one if the trial is shorter."""


class Kept(NamedTuple):
    """A screen as it was shown.

    Attributes:
        screen: its values.
        now_ns: when, session time.
        pictures: of the robots, uint8 [n, height, width, 3]; None if the task took none.
    """

    screen: Screen
    now_ns: int
    pictures: npt.NDArray[np.uint8] | None = None


class _Album:
    """Keeps one screen of each kind: of a trial, the one at `MOMENT`."""

    def __init__(self, clock: VirtualClock) -> None:
        self._clock = clock
        self._prompts: dict[str, str] = {}
        self._pictures: npt.NDArray[np.uint8] | None = None
        self.kept: dict[str, Kept] = {}

    def take(self, pictures: npt.NDArray[np.uint8]) -> None:
        """Take the pictures that belong to the next screens."""
        self._pictures = pictures

    def keep(self, screen: Screen) -> None:
        """Take in a screen that is shown."""
        name = _name(screen)
        if isinstance(screen, SurveyScreen):
            # Asked again after the reveal, the same questions have another prompt.
            again = self._prompts.setdefault(name, screen.prompt) != screen.prompt
            name += "_after_reveal" if again else ""
        late = isinstance(screen, FleetScreen) and screen.timestep > MOMENT
        if name not in self.kept or not late:
            self.kept[name] = Kept(screen, self._clock.now_ns, self._pictures)


def _name(screen: Screen) -> str:
    """Return a name that tells kinds of screens apart."""
    kind = type(screen).__name__.removesuffix("Screen").lower()
    if isinstance(screen, FleetScreen):
        offered = "_offered" if 1 < len(screen.tiles) < screen.robots else ""
        return f"{kind}_{screen.allocation}_{screen.view}_{screen.robots}{offered}"
    if isinstance(screen, PageScreen) and not (screen.paragraphs or screen.figure):
        return f"ready_{'episode' if screen.robots == 1 else 'trial'}"
    if isinstance(screen, WaitScreen):
        return f"{kind}_{'fit' if screen.progress < 0 else 'phase_four'}"
    title = getattr(screen, "title", "") or getattr(screen, "header_left", "")
    words = "".join(letter if letter.isalnum() else "_" for letter in title.lower())
    return f"{kind}_{words[:60].strip('_')}".strip("_")


@dataclasses.dataclass(frozen=True, slots=True)
class Look:
    """How screens are drawn.

    Attributes:
        size: width and height, px.
        ui_scale: text so much larger than suits the size.
        messages: the texts of a language.
    """

    size: tuple[int, int]
    ui_scale: float
    messages: Messages

    @property
    def name(self) -> str:
        """Name of a folder for it."""
        return f"{self.size[0]}x{self.size[1]}_{self.ui_scale:g}_{self.messages.locale}"


def screens_of(loaded: LoadedProtocol, messages: Messages) -> dict[str, Kept]:
    """Run a simulated session whose participant reads these texts.

    Returns:
        One screen of each kind by name, in order of appearance.
    """
    (assignment,) = simulated_assignments(loaded, 1, seed=1)
    clock = VirtualClock()
    album = _Album(clock)
    fitter = InlineFitter(loaded.description, recorded_weights(loaded))
    run_unrecorded(
        loaded, assignment, messages, clock,
        fitter=fitter, on_show=album.keep, on_pictures=album.take,
    )  # fmt: skip
    album.keep(PauseScreen(reason="", confirm_stop=False, can_erase=True))
    for question in ("confirm_stop", "confirm_erase"):
        asked = PauseScreen(reason="", confirm_stop=question == "confirm_stop", can_erase=True,
                            confirm_erase=question == "confirm_erase")  # fmt: skip
        album.kept[f"pause_{question}"] = Kept(asked, clock.now_ns)
    held = PauseScreen(reason=messages.say(HELD), confirm_stop=False, can_erase=True,
                       can_go_on=False)  # fmt: skip
    album.kept["pause_held"] = Kept(held, clock.now_ns)
    return album.kept


def draw_screens(screens: dict[str, Kept], folder: Path, look: Look) -> list[Path]:
    """Draw screens from their values alone.

    Args:
        screens: by name.
        folder: where the PNG files go.
        look: how they are drawn.

    Returns:
        The pictures, in order.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StudyError(
            f"the folder {folder} cannot be made: {error.strerror}", "Choose another with -o."
        ) from error
    pictures = []
    for number, (name, kept) in enumerate(screens.items(), start=1):
        surface = pygame.Surface(look.size)
        shots = Pictures()
        shots.take([] if kept.pictures is None else kept.pictures)
        renderer = Renderer(look.size, look.ui_scale, look.messages, shots)
        renderer.draw(surface, kept.screen, kept.now_ns)
        pictures.append(folder / f"{number:02d}_{name}.png")
        _save(surface, pictures[-1])
    return pictures


def _save(surface: pygame.Surface, path: Path) -> None:
    """Write a picture; pygame itself says nothing of a full disk."""
    packed = io.BytesIO()
    pygame.image.save(surface, packed, "picture.png")
    try:
        path.write_bytes(packed.getvalue())
    except OSError as error:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)
        raise StudyError(
            f"{path} cannot be written: {error.strerror}", "Give another folder with --output."
        ) from error


def draw_gallery(loaded: LoadedProtocol, folder: Path, looks: Sequence[Look]) -> list[Path]:
    """Run a simulated session and draw one screen of each kind.

    Args:
        loaded: the protocol.
        folder: where the PNG files go; with several looks, into a folder each.
        looks: how they are drawn.

    Returns:
        The pictures, in the order in which their screens came up.
    """
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    pygame.font.init()
    pictures = []
    of_language: dict[str, dict[str, Kept]] = {}
    for look in looks:
        language = look.messages.locale
        if language not in of_language:
            of_language[language] = screens_of(loaded, look.messages)
        screens = of_language[language]
        place = folder / look.name if len(looks) > 1 else folder
        pictures += draw_screens(screens, place, look)
    return pictures
