"""Where a replay is and how fast it goes. No window, no clock: time is handed in."""

from __future__ import annotations

from collections.abc import Sequence

from study.shell.replay.marks import Marks

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
LEAP_NS = 5_000_000_000
BACK_MARGIN_NS = 700_000_000
"""While it plays, a mark passed so short a time ago is passed over on the way back."""
KEYS = (
    ("space", "play, pause"),
    ("left right", "5 s"),
    ("down up", "speed"),
    ("p n", "takeover"),
    ("r t", "trial"),
    ("backspace", "start"),
    ("v", "view"),
    ("q", "quit"),
)
"""Names of keys, and what they do; of two the first goes back."""


class Player:
    """Plays from a time on, and jumps.

    Args:
        marks: of the session.
        t_ns: session time to begin at.
        speed: session seconds a second, one of `SPEEDS`.

    Attributes:
        t_ns: session time now.
        playing: whether time goes on.
        speed: session seconds a second.
    """

    def __init__(self, marks: Marks, t_ns: int = 0, speed: float = 1.0) -> None:
        self._last_ns = marks.last_ns
        self._takeovers = [takeover.t_ns for takeover in marks.takeovers]
        self._trials = [trial.first_ns for trial in marks.of_kind("trial")]
        self.t_ns = 0
        self.playing = True
        self.speed = speed
        self.seek(t_ns)

    def advance(self, elapsed_ns: int) -> None:
        """Let time pass, ns by the clock on the wall; at the end the replay stands still."""
        if not self.playing:
            return
        self.seek(self.t_ns + round(elapsed_ns * self.speed))
        if self.t_ns >= self._last_ns:
            self.playing = False

    def seek(self, t_ns: int) -> None:
        """Go to a session time, or to the nearest end."""
        self.t_ns = min(self._last_ns, max(0, t_ns))

    def press(self, key: str) -> None:
        """Do what a key means; see `KEYS`."""
        if key == "space":
            if not self.playing and self.t_ns >= self._last_ns:
                self.seek(0)
            self.playing = not self.playing
        elif key in ("left", "right"):
            self.seek(self.t_ns + (LEAP_NS if key == "right" else -LEAP_NS))
        elif key in ("up", "down"):
            place = SPEEDS.index(self.speed) + (1 if key == "up" else -1)
            self.speed = SPEEDS[min(len(SPEEDS) - 1, max(0, place))]
        elif key == "n":
            self._next(self._takeovers)
        elif key == "p":
            self._previous(self._takeovers)
        elif key == "t":
            self._next(self._trials)
        elif key == "r":
            self._previous(self._trials)
        elif key == "backspace":
            self.seek(0)

    def _next(self, times_ns: Sequence[int]) -> None:
        self.seek(next((t for t in times_ns if t > self.t_ns), self.t_ns))

    def _previous(self, times_ns: Sequence[int]) -> None:
        margin = BACK_MARGIN_NS if self.playing else 0
        self.seek(next((t for t in reversed(times_ns) if t < self.t_ns - margin), self.t_ns))
