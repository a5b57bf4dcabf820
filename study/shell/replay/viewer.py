"""The window in which a replay is watched."""

from __future__ import annotations

import gc
import time
from contextlib import suppress

import pygame

from study.messages import Messages
from study.screens import Screen, WaitScreen
from study.shell.raw_inputs import RawClose, RawKey, RawPointer
from study.shell.replay.camera import Camera
from study.shell.replay.marks import Marks
from study.shell.replay.picture import Picture, View, size_for
from study.shell.replay.player import Player
from study.shell.replay.strip import Shown, clock
from study.shell.replay.tape import Tape
from study.shell.window import SMALLEST, Window

SECOND = 1_000_000_000
READ_S = 0.006
"""Reading ahead between two pictures; the rest of the time is for drawing."""
READ_WAITED_FOR_S = 0.05
SHARE_OF_DESKTOP = 0.92
"""Of a desktop's height, for a window with a frame and a bar beside it."""
NOTHING: Screen = WaitScreen(title="", text="", progress=-1.0)


class Viewer:
    """Plays a tape in a window until it is closed.

    Args:
        tape: of the session.
        marks: of the session.
        player: where it begins, and how fast.
        view: what is shown first.
        messages: the texts that the participant read.
        size: of the window, pixels; what suits the recording and the desktop if None.
        ui_scale: that of the participant's window.
        camera: takes the pictures of tasks that show some.

    Raises:
        StudyError: there is no display, or the window is too small.
    """

    def __init__(
        self,
        tape: Tape,
        marks: Marks,
        player: Player,
        view: View,
        messages: Messages,
        size: tuple[int, int] | None = None,
        ui_scale: float = 1.0,
        camera: Camera | None = None,
    ) -> None:
        self._camera = camera
        self._tape, self._marks, self._player = tape, marks, player
        self._view, self._messages, self._ui_scale = view, messages, ui_scale
        self._shown = Shown(tape.go_to(0), 0, playing=False, speed=player.speed)
        self._asked_ns = -1
        self._open = True
        self._picture: Picture | None = None
        self._window = Window(
            size or fitting_size(view, marks), caption="Replay", painter=self._painter
        )

    def run(self) -> None:
        """Play until the window is closed."""
        window, player = self._window, self._player
        period = SECOND / window.refresh_hz
        last = deadline = time.perf_counter_ns()
        captioned = ""
        try:
            while self._open:
                for raw in window.poll():
                    self._take(raw)
                now = time.perf_counter_ns()
                if self._ready():
                    player.advance(now - last)
                last = now
                self._show()
                window.show(NOTHING)
                window.draw(player.t_ns)
                caption = f"Replay of {self._marks.participant}, {clock(player.t_ns)[:-2]}"
                if caption != captioned:
                    window.set_caption(caption)
                    captioned = caption
                deadline = max(deadline + round(period), time.perf_counter_ns())
                if not self._tape.is_read:
                    self._tape.read(READ_S)
                    if self._tape.is_read:
                        # What is kept stays: no garbage collection walks it and holds up a picture.
                        gc.collect()
                        gc.freeze()
                window.wait(max(0, deadline - time.perf_counter_ns()) / SECOND)
        finally:
            window.close()

    def _ready(self) -> bool:
        """Return whether the recording is read to where the replay is; read on if not."""
        tape, player = self._tape, self._player
        if not tape.is_read and tape.read_ns <= player.t_ns:
            tape.read(READ_WAITED_FOR_S)
        return tape.is_read or tape.read_ns > player.t_ns

    def _show(self) -> None:
        """Bring the session to where the replay is, if it is read that far."""
        tape, player = self._tape, self._player
        ready = tape.is_read or tape.read_ns > player.t_ns
        head = tape.go_to(player.t_ns) if ready else self._shown.head
        share = -1.0 if ready else max(0, tape.read_ns) / max(1, self._marks.last_ns)
        self._shown = Shown(head, player.t_ns, player.playing, player.speed, share)

    def _take(self, raw: object) -> None:
        """Obey a key, a click or the closing of the window."""
        if isinstance(raw, RawClose):
            self._open = False
        elif isinstance(raw, RawPointer) and raw.target.startswith("seek:"):
            self._player.seek(int(raw.target.removeprefix("seek:")))
        elif isinstance(raw, RawKey) and raw.down:
            if raw.key in ("q", "escape"):
                self._open = False
            elif raw.key == "v":
                self._view = "analyst" if self._view == "participant" else "participant"
                if self._picture is not None:
                    self._picture.view = self._view
            else:
                self._player.press(raw.key)

    def _painter(self, size: tuple[int, int]) -> _Painter:
        self._picture = Picture(
            size, self._marks, self._view, self._messages, self._ui_scale, self._camera
        )
        return _Painter(self, self._picture)

    @property
    def shown(self) -> Shown:
        """What is shown now."""
        return self._shown


class _Painter:
    """Draws the replay where a window draws a participant's screen."""

    def __init__(self, viewer: Viewer, picture: Picture) -> None:
        self._viewer = viewer
        self._picture = picture

    def draw(
        self,
        surface: pygame.Surface,
        screen: Screen,  # noqa: ARG002 - the viewer knows what is shown
        now_ns: int,  # noqa: ARG002
    ) -> list[pygame.Rect] | None:
        """Draw what the viewer shows."""
        self._picture.draw(surface, self._viewer.shown)
        return None

    def hit(self, screen: Screen, x: float, y: float) -> str:  # noqa: ARG002
        """Return "seek:NS" for a place on a timeline, "" elsewhere."""
        t_ns = self._picture.time_at(x, y)
        return "" if t_ns is None else f"seek:{t_ns}"


def fitting_size(view: View, marks: Marks) -> tuple[int, int]:
    """Return the size of a window that shows the participant's screen, and fits the desktop."""
    width, height = size_for(view, marks)
    with suppress(pygame.error):
        pygame.display.init()
        for desktop in pygame.display.get_desktop_sizes()[:1]:
            if height > desktop[1] or width > desktop[0]:
                width = min(width, desktop[0])
                height = min(height, round(desktop[1] * SHARE_OF_DESKTOP))
    return max(SMALLEST[0], width), max(SMALLEST[1], height)
