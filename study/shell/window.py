"""The participant's window: shows screens, and hands out what keys and mouse did.

pygame's events carry no time, so each is stamped when it is taken from the queue. Keys are read
from their events, never by asking what is held: that would miss short taps.
"""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

import pygame

from study.allocation import give_large_blocks_back
from study.errors import StudyError
from study.messages import Messages
from study.screens import Screen, SurveyScreen
from study.shell.drawing.lettering import clear_fonts
from study.shell.drawing.pictures import Pictures
from study.shell.drawing.renderer import Renderer
from study.shell.interrupts import ctrl_c_later
from study.shell.keyboard import key_name
from study.shell.pygame_check import require_pygame_ce
from study.shell.raw_inputs import (
    RawClose,
    RawFocus,
    RawInput,
    RawKey,
    RawPointer,
    RawText,
    RawWindow,
)

SMALLEST = (1280, 720)
LARGEST = (7680, 4320)
"""The largest displays made; a mistyped size would take all memory."""
LARGEST_UI_SCALE = 2.0
WATCHED = (
    pygame.KEYDOWN,
    pygame.KEYUP,
    pygame.MOUSEBUTTONDOWN,
    pygame.WINDOWFOCUSGAINED,
    pygame.WINDOWFOCUSLOST,
    pygame.WINDOWEXPOSED,
    pygame.WINDOWSIZECHANGED,
    pygame.WINDOWMINIMIZED,
    pygame.WINDOWRESTORED,
    pygame.TEXTINPUT,
    pygame.QUIT,
)
DEFAULT_REFRESH_HZ = 60.0

CHANGES = {
    pygame.WINDOWSIZECHANGED: "resized",
    pygame.WINDOWMINIMIZED: "minimised",
    pygame.WINDOWRESTORED: "restored",
}

UNSEEN_DRIVERS = ("offscreen", "dummy", "evdev")
"""SDL falls back to these without a word where there is no display."""


def _refuse_unseen(driver: str) -> None:
    """Refuse a window that nobody can see, unless it was asked for.

    Raises:
        pygame.error: SDL chose a driver without a display by itself.
    """
    if driver in UNSEEN_DRIVERS and os.environ.get("SDL_VIDEODRIVER") != driver:
        raise pygame.error("there is no display")


def check_size(size: tuple[int, int] | None) -> tuple[int, int] | None:
    """Return the size asked for if the screens have room in it, or None if none was.

    Raises:
        StudyError: it is too small, or larger than any display.
    """
    if size is None:
        return None
    asked = f"a window of {size[0]}x{size[1]} pixels was asked for"
    if size[0] < SMALLEST[0] or size[1] < SMALLEST[1]:
        raise StudyError(asked, f"It needs at least {SMALLEST[0]}x{SMALLEST[1]}.")
    if size[0] > LARGEST[0] or size[1] > LARGEST[1]:
        raise StudyError(asked, f"It has at most {LARGEST[0]}x{LARGEST[1]}.")
    return size


def check_ui_scale(factor: float) -> float:
    """Return a factor by which text is larger.

    Raises:
        StudyError: it is not from 1 to 2.
    """
    if not 1.0 <= factor <= LARGEST_UI_SCALE:
        raise StudyError(
            f"a UI scale of {factor:g}",
            f"Give one from 1 to {LARGEST_UI_SCALE:g}; 1 is what suits the window's size.",
        )
    return factor


class Painter(Protocol):
    """What draws a window's screens, at one size."""

    def draw(
        self, surface: pygame.Surface, screen: Screen, now_ns: int
    ) -> list[pygame.Rect] | None:
        """Draw a screen; return the places that changed, pixels, or None if all of it did."""
        ...

    def hit(self, screen: Screen, x: float, y: float) -> str:
        """Return what a click at (x, y), pixels, hits; "" for nothing."""
        ...


class Window:
    """An open window.

    Args:
        size: pixels; None takes the whole screen if ``fullscreen``, else 1280x960.
        fullscreen: whether it fills the screen.
        ui_factor: 1 to 2 times the size of text that suits the window; less where that does not
            fit.
        caption: what the window is called.
        messages: the texts of the participant's language; English if None.
        painter: makes what draws the screens at a size, for a window that a participant does not
            answer in; None for the participant's.

    Attributes:
        pictures: of the robots, where the task takes some.

    Raises:
        StudyError: there is no display, it is too small, or pygame is not pygame-ce.
    """

    def __init__(
        self,
        size: tuple[int, int] | None = None,
        *,
        fullscreen: bool = False,
        ui_factor: float = 1.0,
        caption: str = "Study",
        messages: Messages | None = None,
        painter: Callable[[tuple[int, int]], Painter] | None = None,
    ) -> None:
        require_pygame_ce()
        check_size(size)
        give_large_blocks_back()
        # Software X servers flip 30 times faster without it; read when the display opens.
        os.environ.setdefault("SDL_FRAMEBUFFER_ACCELERATION", "0")
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        try:
            pygame.display.init()
            pygame.font.init()
            _refuse_unseen(pygame.display.get_driver())
            wanted = size or ((0, 0) if fullscreen else (1280, 960))
            flags = pygame.FULLSCREEN if fullscreen else 0
            # pygame takes what is raised while it loads its icon for a missing icon.
            with ctrl_c_later():
                self._surface = pygame.display.set_mode(wanted, flags)
        except pygame.error as error:
            pygame.display.quit()
            raise StudyError(
                f"no window can be opened: {error}",
                "Run it on a desktop, or with SDL_VIDEODRIVER=dummy to run without a display.",
            ) from error
        self.size: tuple[int, int] = self._surface.get_size()
        self.fullscreen = fullscreen
        scale = check_ui_scale(ui_factor)
        self._answered = painter is None
        self.pictures = Pictures()
        self._make = painter or (lambda size: Renderer(size, scale, messages, self.pictures))
        self._painter = self._make(self.size)
        self._screen: Screen | None = None
        self._exposed = True
        self._unshown: list[pygame.Rect] | None = []
        self._blank = True
        self._text_input = False
        self._last_poll_ns = time.perf_counter_ns()
        self._waiting: deque[pygame.event.Event] = deque()
        pygame.key.set_repeat()
        pygame.key.stop_text_input()
        pygame.event.set_blocked(None)
        pygame.event.set_allowed(WATCHED)
        self.set_caption(caption)

    @property
    def driver(self) -> str:
        """SDL's video driver: "x11", "wayland", "dummy", ..."""
        return pygame.display.get_driver()

    @property
    def refresh_hz(self) -> float:
        """Rate at which the display shows pictures; 60 where it does not say."""
        rate = pygame.display.get_current_refresh_rate()
        return float(rate) if rate > 0 else DEFAULT_REFRESH_HZ

    @property
    def window_id(self) -> int:
        """The window's number under X11; 0 elsewhere."""
        return int(pygame.display.get_wm_info().get("window", 0)) if self.driver == "x11" else 0

    @property
    def screen(self) -> Screen | None:
        """The screen shown."""
        return self._screen

    def set_caption(self, caption: str) -> None:
        """Name the window."""
        pygame.display.set_caption(caption)

    def show(self, screen: Screen) -> None:
        """Show a screen from the next picture on."""
        self._screen = screen
        takes_text = self._answered and isinstance(screen, SurveyScreen) and screen.takes_text
        if takes_text and not self._text_input:
            pygame.key.start_text_input()
        elif self._text_input and not takes_text:
            pygame.key.stop_text_input()
        self._text_input = takes_text

    def draw(self, now_ns: int) -> None:
        """Paint the screen as it is at a session time, and put it on the display."""
        self.paint(now_ns)
        self.present()

    def paint(self, now_ns: int) -> None:
        """Paint the screen as it is at a session time; the display shows it when it is presented.

        Painting takes longer for one picture than for another, presenting hardly does: who paints
        ahead can present at equal intervals.
        """
        changed = None
        if self._screen is not None:
            changed = self._painter.draw(self._surface, self._screen, now_ns)
        self._blank = False
        if changed is None or self._unshown is None:
            self._unshown = None
        else:
            self._unshown += changed

    def present(self) -> None:
        """Put on the display what was painted since the last time."""
        if self._blank:
            return
        changed, self._unshown = self._unshown, []
        if changed is None or self._exposed:
            self._exposed = False
            pygame.display.flip()
        elif changed:
            pygame.display.update(changed)

    def poll(self) -> list[RawInput]:
        """Take everything from the event queue, oldest first."""
        events = [*self._waiting, *pygame.event.get()]
        self._waiting.clear()
        now = time.perf_counter_ns()
        gap, self._last_poll_ns = now - self._last_poll_ns, now
        return [raw for event in events if (raw := self._raw(event, now, gap)) is not None]

    def wait(self, seconds: float) -> None:
        """Sleep until a key, the mouse or the window has something to say, or until time is up."""
        milliseconds = int(seconds * 1000)
        if self._waiting:
            return
        if milliseconds < 1:
            # SDL takes 0 for "for ever".
            time.sleep(max(0.0, seconds))
            return
        event = pygame.event.wait(milliseconds)
        if event.type != pygame.NOEVENT:
            self._waiting.append(event)

    def close(self) -> None:
        """Close the window."""
        clear_fonts()
        pygame.font.quit()
        pygame.display.quit()

    def _raw(self, event: pygame.event.Event, now: int, gap: int) -> RawInput | None:
        if event.type in (pygame.KEYDOWN, pygame.KEYUP):
            name = key_name(event.key, getattr(event, "scancode", 0))
            return RawKey(name, event.type == pygame.KEYDOWN, now, gap) if name else None
        if event.type == pygame.MOUSEBUTTONDOWN and event.button == pygame.BUTTON_LEFT:
            x, y = event.pos
            target = "" if self._screen is None else self._painter.hit(self._screen, x, y)
            return RawPointer(float(x), float(y), target, now, gap)
        if event.type in (pygame.WINDOWFOCUSGAINED, pygame.WINDOWFOCUSLOST):
            return RawFocus(event.type == pygame.WINDOWFOCUSGAINED, now, gap)
        if event.type == pygame.WINDOWEXPOSED:
            # What another window covered is sent to the display again.
            self._exposed = True
        if event.type == pygame.TEXTINPUT:
            return RawText(event.text, now, gap) if self._text_input else None
        if event.type in CHANGES:
            return self._changed(CHANGES[event.type], now, gap)
        if event.type == pygame.QUIT:
            return RawClose(now, gap)
        return None

    def _changed(self, change: str, now: int, gap: int) -> RawInput | None:
        """Draw at the new size from now on; the size that the window opens with is no change."""
        size = pygame.display.get_window_size()
        if change == "resized":
            if size == self.size:
                return None
            self._surface = pygame.display.get_surface() or self._surface
            self.size = self._surface.get_size()
            self._painter = self._make(self.size)
            # What was painted at the old size is lost: the new surface is empty until painted.
            self._unshown, self._blank = [], True
        return RawWindow(change, *size, now, gap)
