"""A stand-in for eyes: what is on the screen, by replaying the recording while it grows."""

from __future__ import annotations

from pathlib import Path

import pygame

from study.errors import StudyError
from study.events.events import Event
from study.events.inputs import Input, KeyChanged, PointerPressed
from study.recording.reader import read_recording
from study.recording.wire import decode
from study.screens import Screen
from study.session.session import Session
from study.shell.drawing.renderer import Renderer


class Onlooker:
    """Follows a session from its recording alone.

    Args:
        folder: where the one recording grows.

    Attributes:
        keys: key events recorded so far.
        presses: places of the mouse's presses recorded so far.
        events: what followed from the inputs so far.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._session = Session()
        self._size = 0
        self._sequence = -1
        self.keys: list[tuple[str, bool]] = []
        self.presses: list[tuple[float, float]] = []
        self.events: list[Event] = []

    def look(self) -> Screen | None:
        """Return what is shown after the last input recorded; None before the first."""
        try:
            for path in self._folder.glob("*.mcap*"):
                size = path.stat().st_size
                if size != self._size:
                    self._read(path)
                    self._size = size
        except (StudyError, FileNotFoundError):
            pass  # The file is being made or moved into place.
        return self._session.screen

    def _read(self, path: Path) -> None:
        for raw in read_recording(path).raw("input"):
            if raw.sequence <= self._sequence:
                continue
            self._sequence = raw.sequence
            given: Input = decode(raw.topic, raw.data)  # type: ignore[assignment]
            if isinstance(given, KeyChanged):
                self.keys.append((given.key, given.down))
            elif isinstance(given, PointerPressed):
                self.presses.append((given.x, given.y))
            self.events += self._session.handle(given).events


class Aim:
    """Knows where on a window things are drawn.

    Args:
        size: of the window, pixels.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        pygame.font.init()
        self._renderer = Renderer(size)

    def at(self, screen: Screen, target: str) -> tuple[int, int]:
        """Return the middle of a target, which must be hit there."""
        places = [place for name, place in self._renderer.targets(screen) if name == target]
        assert places, f"nothing on the {type(screen).__name__} is {target}"
        x, y = places[-1].center
        assert self._renderer.hit(screen, x, y) == target
        return x, y
