"""What the participant's window says when a session is over before its last screen.

The session has ended by then and its recording is closed: nothing of this is recorded. Without it
the window would be gone in the middle of a trial, and nobody in the room would have said why.
"""

from __future__ import annotations

import contextlib
import time
from typing import Literal

from study.messages import Messages, noted
from study.screens import EndScreen
from study.shell.raw_inputs import RawClose, RawKey, RawPointer
from study.shell.window import UNSEEN_DRIVERS, Window

Ending = Literal["ended", "erased", "declined", "failed"]
_TELL = noted("Please tell the experimenter.")
_WORDS: dict[Ending, tuple[str, str]] = {
    "ended": (noted("The session has ended. Thank you!"), _TELL),
    "erased": (
        noted("The session has ended. Thank you!"),
        noted("What was recorded of you has been erased. Please tell the experimenter."),
    ),
    "declined": (
        noted("Thank you for your time."),
        noted("You do not take part, and nothing was recorded. Please tell the experimenter."),
    ),
    "failed": (noted("The session cannot go on."), _TELL),
}
DEAF_NS = 1_000_000_000
"""In which no key closes the window: it may still be meant for robots or questions."""
_LOOK_EVERY_S = 0.05


class LastWords:
    """Holds a session's window open for last words, until somebody closes them.

    Args:
        messages: the texts of the participant's language.
    """

    def __init__(self, messages: Messages) -> None:
        self._messages = messages
        self._window: Window | None = None
        self._since_ns = 0

    @property
    def awaited(self) -> bool:
        """Whether a window is open that has words to show."""
        return self._window is not None

    def keeps(self, window: Window) -> bool:
        """Return whether a window is kept open for words."""
        return self._window is window

    def keep(self, window: Window, ending: Ending) -> None:
        """Show how the session ended from now on; a window that nobody can see is not kept."""
        if window.driver in UNSEEN_DRIVERS:
            return
        self._window, self._since_ns = window, time.perf_counter_ns()
        self.say(ending)

    def say(self, ending: Ending) -> None:
        """Say how it ended in other words, if a window is open."""
        if self._window is None:
            return
        title, text = _WORDS[ending]
        say = self._messages.say
        self._window.show(EndScreen(say(title), say(text), achieved=False))
        self._window.draw(0)

    def wait(self) -> None:
        """Wait until Enter, Escape, a click on the button, or the window is closed; or Ctrl-C."""
        window = self._window
        if window is None:
            return
        # All is saved and told by now: Ctrl-C only closes the window.
        with contextlib.suppress(KeyboardInterrupt):
            while not self._closed(window):
                window.draw(0)
                window.wait(_LOOK_EVERY_S)
        self.close()

    def close(self) -> None:
        """Close the window, if it is still open."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _closed(self, window: Window) -> bool:
        """Take what was pressed; return whether any of it closes the window."""
        for raw in window.poll():
            if isinstance(raw, RawClose):
                return True
            late = time.perf_counter_ns() - self._since_ns >= DEAF_NS
            if isinstance(raw, RawKey) and raw.down and raw.key in ("return", "escape") and late:
                return True
            if isinstance(raw, RawPointer) and raw.target == "confirm" and late:
                return True
        return False
