"""A stand-in for hands: a private X server, and real X11 key and mouse events in it."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt
import pytest
from Xlib import XK, X
from Xlib.display import Display
from Xlib.error import XError
from Xlib.ext import xtest
from Xlib.xobject.drawable import Window

from patience import PATIENCE_S

KEYSYMS = {
    "up": "Up",
    "down": "Down",
    "left": "Left",
    "right": "Right",
    "return": "Return",
    "escape": "Escape",
    "tab": "Tab",
    "backspace": "BackSpace",
    "space": "space",
    "-": "minus",
    "=": "equal",
    "f12": "F12",
}


def require_program(name: str) -> str:
    """Return the program's path; skip the test where it is missing, but fail in CI."""
    path = shutil.which(name)
    if path is None:
        reason = f"needs the program {name}"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    return path


@contextmanager
def x_server(width: int = 1280, height: int = 960) -> Iterator[str]:
    """Start a virtual X server; yield its display name."""
    program = require_program("Xvfb")
    read, write = os.pipe()
    command = [program, "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24"]
    server = subprocess.Popen(
        [*command, "-nolisten", "tcp"], pass_fds=(write,), stderr=subprocess.DEVNULL
    )
    os.close(write)
    try:
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        assert number, "Xvfb did not start"
        yield f":{number}"
    finally:
        server.terminate()
        server.wait(PATIENCE_S)


class Hands:
    """Presses keys and buttons; remembers every key event and click sent, in order."""

    def __init__(self, display: str) -> None:
        self._display = Display(display)
        self.sent: list[tuple[str, bool]] = []
        self.clicked: list[tuple[int, int]] = []

    def wait_for_window(self, timeout_s: float = PATIENCE_S) -> Window:
        """Wait until a window is mapped, and give it the keyboard."""
        deadline = time.monotonic() + timeout_s
        root = self._display.screen().root
        while time.monotonic() < deadline:
            for window in root.query_tree().children:
                # A program may close one window and open another.
                with contextlib.suppress(XError):
                    attributes = window.get_attributes()
                    if attributes.map_state == X.IsViewable and window.get_geometry().width > 200:
                        window.set_input_focus(X.RevertToPointerRoot, X.CurrentTime)
                        self._display.sync()
                        return window
            time.sleep(0.05)
        raise AssertionError("no window appeared")

    def focus_whatever_is_there(self) -> None:
        """Give a window the keyboard, if there is one: a program may close one and open another."""
        for window in self._display.screen().root.query_tree().children:
            with contextlib.suppress(XError):
                if window.get_attributes().map_state == X.IsViewable:
                    window.set_input_focus(X.RevertToPointerRoot, X.CurrentTime)
        self._display.sync()

    def resize(self, width: int, height: int) -> None:
        """Give the window another size, from the screen's corner on, as a window manager does."""
        self.wait_for_window().configure(x=0, y=0, width=width, height=height)
        self._display.sync()

    def minimise(self) -> Window:
        """Take the window off the screen, as a window manager does; return it."""
        window = self.wait_for_window()
        window.unmap()
        self._display.sync()
        return window

    def restore(self, window: Window) -> None:
        """Put a minimised window back and give it the keyboard."""
        window.map()
        self.wait_for_window()

    def key(self, name: str, *, down: bool) -> None:
        """Send one key event."""
        keysym = XK.string_to_keysym(KEYSYMS.get(name, name))
        code = self._display.keysym_to_keycode(keysym)
        xtest.fake_input(self._display, X.KeyPress if down else X.KeyRelease, code)
        self._display.sync()
        self.sent.append((name, down))

    def tap(self, name: str, hold_s: float = 0.03) -> None:
        """Press and release a key, and lift the finger."""
        self.key(name, down=True)
        time.sleep(hold_s)
        self.key(name, down=False)
        # SDL takes a press within 2 ms of the same key's release for the keyboard's repetition.
        time.sleep(0.03)

    def click(self, x: int, y: int) -> None:
        """Move the pointer and click the left button."""
        xtest.fake_input(self._display, X.MotionNotify, x=x, y=y)
        self._display.sync()
        time.sleep(0.03)
        for kind in (X.ButtonPress, X.ButtonRelease):
            xtest.fake_input(self._display, kind, 1)
        self._display.sync()
        self.clicked.append((x, y))

    def picture(self) -> npt.NDArray[np.uint8]:
        """Return what the window shows: uint8 [height, width, 3], red first."""
        window = self.wait_for_window()
        size = window.get_geometry()
        image = window.get_image(0, 0, size.width, size.height, X.ZPixmap, 0xFFFFFFFF)
        pixels = np.frombuffer(image.data, np.uint8).reshape(size.height, size.width, 4)
        return pixels[..., 2::-1]

    def caption(self) -> str:
        """Return what the window is called."""
        kinds = [self._display.intern_atom(name) for name in ("_NET_WM_NAME", "UTF8_STRING")]
        found = self.wait_for_window().get_full_property(*kinds)
        return found.value.decode() if found else ""

    def close(self) -> None:
        """Let go of the server."""
        self._display.close()
