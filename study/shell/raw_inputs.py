"""What the window saw, stamped by the machine's clock; the loop turns it into inputs.

Nothing here knows the session's time: ``at_perf_ns`` is ``time.perf_counter_ns()`` when the
event was taken from the queue, ``poll_gap_ns`` the time since the queue was read before, which
bounds how much earlier it happened.
"""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True, slots=True)
class RawKey:
    """A key went down or up; ``key`` is a name of `study.shell.keyboard`."""

    key: str
    down: bool
    at_perf_ns: int
    poll_gap_ns: int


@dataclasses.dataclass(frozen=True, slots=True)
class RawPointer:
    """The left mouse button went down at (x, y), pixels, on ``target`` of the screen shown."""

    x: float
    y: float
    target: str
    at_perf_ns: int
    poll_gap_ns: int


@dataclasses.dataclass(frozen=True, slots=True)
class RawFocus:
    """The window lost or regained the keyboard."""

    focused: bool
    at_perf_ns: int
    poll_gap_ns: int


@dataclasses.dataclass(frozen=True, slots=True)
class RawText:
    """Characters were typed; only while the screen takes text."""

    text: str
    at_perf_ns: int
    poll_gap_ns: int


@dataclasses.dataclass(frozen=True, slots=True)
class RawWindow:
    """The window was "resized", "minimised" or "restored"; its size then, pixels."""

    change: str
    width: int
    height: int
    at_perf_ns: int
    poll_gap_ns: int


@dataclasses.dataclass(frozen=True, slots=True)
class RawClose:
    """The window was asked to close."""

    at_perf_ns: int
    poll_gap_ns: int


RawInput = RawKey | RawPointer | RawFocus | RawText | RawWindow | RawClose
