"""The loop of a person's session: a real window, the real clock, absolute deadlines."""

from __future__ import annotations

import gc
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import numpy as np

from study.allocation import give_holes_back
from study.console.link import ConsoleLink
from study.events.experimenter_records import ExperimenterCommanded
from study.events.inputs import (
    FocusChanged,
    Input,
    KeyChanged,
    PointerPressed,
    QuitRequested,
    RecordingInterrupted,
    RecordingRestored,
    TextTyped,
    TimestepDue,
    WindowChanged,
)
from study.events.shell import ClockPair, DisplayOpened, FrameIntervals, Note, WriterHealth
from study.recording.failover import FailoverRecorder
from study.screens import Screen
from study.shell.conductor import Conductor
from study.shell.fleet import EMERGENCY_KEY, Emergency
from study.shell.punctuality import Punctuality
from study.shell.raw_inputs import (
    RawClose,
    RawFocus,
    RawInput,
    RawKey,
    RawPointer,
    RawText,
    RawWindow,
)
from study.shell.window import Window

SECOND = 1_000_000_000
CLOCK_PAIR_EVERY_NS = 10 * SECOND
HEALTH_EVERY_NS = SECOND
PAINT_AHEAD = 0.75
"""Share of the time between two pictures by which the next is painted ahead of being presented.

Painting takes longer when much changes; begun early, it still ends before the deadline. It shows
the fleet as it was when painting began: always as long ago, so that motion stays even.
"""
HURRIED_BUDGET_NS = 12_000_000
"""Work done between two pictures where timesteps come as fast as the fleet answers."""


class LiveClock:
    """The session's time: monotonic.

    Args:
        start_ns: what it is now: 0, or more if the session is resumed.
    """

    def __init__(self, start_ns: int = 0) -> None:
        self.origin_perf_ns = time.perf_counter_ns() - start_ns
        self.epoch_ns = time.time_ns() - start_ns

    def now(self) -> int:
        """Return the session's time, ns."""
        return time.perf_counter_ns() - self.origin_perf_ns


class LiveLoop:
    """Runs one session in a window until it is finished.

    Pictures and timesteps come on absolute deadlines, so that neither drifts; between
    them the loop sleeps until a key or a deadline. A picture is painted ahead of its
    deadline, and presented on it.

    Args:
        conductor: the session's hands.
        window: what the participant sees and presses.
        recorder: whose health is watched.
        clock: the session's time.
        console: what an experimenter may watch and command by; None if there is none.
        emergency: stops the robots at `EMERGENCY_KEY`, in any stage; None if there are none.

    Attributes:
        asked_to_close: whether the window was closed, or a signal asked the program to end.
    """

    def __init__(
        self,
        conductor: Conductor,
        window: Window,
        recorder: FailoverRecorder,
        clock: LiveClock,
        console: ConsoleLink | None = None,
        emergency: Emergency | None = None,
    ) -> None:
        self._conductor = conductor
        self._window = window
        self._recorder = recorder
        self._clock = clock
        self._console = console
        self._emergency = emergency
        self._quit_reason = ""
        self.asked_to_close = False
        self._next_due_ns = 0
        self._shown: Screen | None = None
        self._frames: list[int] = []
        self._last_frame_ns = -1
        self._next_pair_ns = 0
        self._next_health_ns = 0
        self._period_ns = round(SECOND / window.refresh_hz)
        self._ahead_ns = round(PAINT_AHEAD * self._period_ns)
        self._trial_id = conductor.trial_id
        self._punctuality = Punctuality(self._period_ns)

    def run(self) -> None:
        """Run to the end of the session."""
        with self._signals():
            # What was loaded stays: no garbage collection walks it and holds up a picture.
            gc.collect()
            gc.freeze()
            self._run()

    def _run(self) -> None:
        window, clock = self._window, self._clock
        period = self._period_ns
        self._conductor.observe(
            DisplayOpened(
                t_ns=clock.now(),
                driver=window.driver,
                width=window.size[0],
                height=window.size[1],
                refresh_hz=window.refresh_hz,
                fullscreen=window.fullscreen,
            )
        )
        next_frame = clock.now() + self._ahead_ns
        painted = False
        while not self._conductor.finished:
            self._watch_recording()
            self._take_inputs()
            self._take_commands()
            self._conductor.collect(clock.now)
            self._step_clock()
            now = clock.now()
            self._note_trial(now)
            if not painted and now >= next_frame - self._ahead_ns:
                self._paint(next_frame - self._ahead_ns)
                painted, now = True, clock.now()
            if painted and now >= next_frame:
                self._present()
                painted = False
                next_frame += period * max(1, -(-(now - next_frame) // period))
                self._observe(now)
            picture = next_frame if painted else next_frame - self._ahead_ns
            deadline = min(picture, self._next_due_ns or picture)
            remaining = deadline - clock.now()
            if remaining > 0 and not self._conductor.finished:
                # An answer may be awaited: look again soon.
                busy = self._conductor.fleet_pending or self._conductor.fit_pending
                window.wait(min(remaining, 2_000_000 if busy else remaining) / SECOND)
        self._note_trial(clock.now())
        self._flush_frames(clock.now())

    def _note_trial(self, now: int) -> None:
        """When a fleet run begins or ends, state how punctual the one before was."""
        trial_id = self._conductor.trial_id
        if trial_id == self._trial_id:
            return
        self._flush_frames(now)
        if self._trial_id >= 0:
            self._conductor.observe(self._punctuality.summary(now, self._trial_id))
        self._trial_id = trial_id
        self._punctuality = Punctuality(self._period_ns)

    def _watch_recording(self) -> None:
        """If the writer failed, stand still until another has all that waited."""
        fault = self._recorder.check(time.perf_counter_ns())
        if fault is None:
            return
        self._conductor.feed(RecordingInterrupted(self._clock.now(), fault))
        # Seen before the wait for the new part.
        self._paint(self._clock.now())
        self._present()
        part = self._recorder.begin_part(fault)
        self._conductor.feed(RecordingRestored(self._clock.now(), part))

    def _take_inputs(self) -> None:
        if self._quit_reason:
            reason, self._quit_reason = self._quit_reason, ""
            self.asked_to_close = True
            self._conductor.feed(QuitRequested(self._clock.now(), reason))
        taken = self._window.poll()
        self._punctuality.poll(self._clock.now())
        for raw in taken:
            if isinstance(raw, RawKey) and raw.down and raw.key == EMERGENCY_KEY:
                self._stop_robots()
            if self._conductor.finished:
                return
            self.asked_to_close |= isinstance(raw, RawClose)
            self._conductor.feed(self._stamped(raw))

    def _stop_robots(self) -> None:
        """Before anything else is done with the key."""
        if self._emergency is not None:
            self._emergency.press()
            self._conductor.observe(Note(self._clock.now(), "emergency stop pressed"))

    def _take_commands(self) -> None:
        """Take what the experimenter asks for, and tell what is to be seen."""
        if self._console is None:
            return
        for command in self._console.poll():
            if self._conductor.finished:
                return
            t_ns = self._clock.now()
            self._conductor.feed(ExperimenterCommanded(t_ns, command.command, command.text))
        self._console.tell(self._clock.now())

    def _stamped(self, raw: RawInput) -> Input:
        t_ns = max(0, raw.at_perf_ns - self._clock.origin_perf_ns)
        if isinstance(raw, RawKey):
            return KeyChanged(t_ns, raw.key, raw.down, raw.poll_gap_ns)
        if isinstance(raw, RawPointer):
            return PointerPressed(t_ns, raw.x, raw.y, raw.target, raw.poll_gap_ns)
        if isinstance(raw, RawFocus):
            return FocusChanged(t_ns, raw.focused)
        if isinstance(raw, RawText):
            return TextTyped(t_ns, raw.text)
        if isinstance(raw, RawWindow):
            return WindowChanged(t_ns, raw.change, raw.width, raw.height)
        assert isinstance(raw, RawClose)  # noqa: S101 - the union has no other member
        return QuitRequested(t_ns, "window closed")

    def _step_clock(self) -> None:
        conductor, clock = self._conductor, self._clock
        pace = conductor.pace
        rate = pace.timesteps_per_second
        if conductor.pace_changed:
            conductor.pace_changed = False
            self._punctuality.stood_still()
            self._next_due_ns = clock.now() + round(SECOND / rate) if rate else 0
        if not rate or conductor.finished:
            return
        if not pace.unhurried:
            self._hurry()
            return
        period = round(SECOND / rate)
        now = clock.now()
        if now >= self._next_due_ns:
            late = now - self._next_due_ns
            # A stall is not caught up with a burst: the steps between are not run.
            self._next_due_ns += period * (1 + late // period)
            self._punctuality.timestep(now)
            conductor.feed(TimestepDue(now, late))

    def _hurry(self) -> None:
        """Step as fast as the fleet answers, for as long as a picture can wait."""
        conductor, clock = self._conductor, self._clock
        self._next_due_ns = 0
        until = clock.now() + HURRIED_BUDGET_NS
        while clock.now() < until and not conductor.finished:
            if conductor.pace.unhurried or not conductor.pace.timesteps_per_second:
                return
            if conductor.fleet_pending:
                conductor.collect(clock.now, wait_s=0.001)
            else:
                conductor.feed(TimestepDue(clock.now(), 0))

    def _paint(self, now: int) -> None:
        """Paint the screen as it is at a session time."""
        screen = self._conductor.screen
        if screen is None:
            return
        if screen is not self._shown:
            self._shown = screen
            self._window.show(screen)
        self._window.paint(now)

    def _present(self) -> None:
        """Put on the display what was painted."""
        if self._shown is None:
            return
        self._window.present()
        shown_ns = self._clock.now()
        if self._last_frame_ns >= 0:
            self._frames.append(shown_ns - self._last_frame_ns)
            self._punctuality.frame(shown_ns - self._last_frame_ns)
        self._last_frame_ns = shown_ns

    def _observe(self, now: int) -> None:
        if now >= self._next_pair_ns:
            self._next_pair_ns = now + CLOCK_PAIR_EVERY_NS
            t_ns = self._clock.now()
            self._conductor.observe(ClockPair(t_ns, time.time_ns()))
            # Else Python's lists of free objects grow for the better part of an hour.
            gc.collect()
            give_holes_back()
        if now >= self._next_health_ns:
            self._next_health_ns = now + HEALTH_EVERY_NS
            recorder = self._recorder
            for remark in recorder.take_remarks():
                self._conductor.observe(Note(now, remark))
            self._conductor.observe(
                WriterHealth(now, recorder.durable_sequence, recorder.sent_sequence)
            )
            self._flush_frames(now)

    def _flush_frames(self, now: int) -> None:
        if self._frames:
            intervals = np.array(self._frames, dtype=np.float64) / SECOND
            self._conductor.observe(FrameIntervals(now, self._trial_id, intervals))
            self._frames.clear()

    @contextmanager
    def _signals(self) -> Iterator[None]:
        """Turn SIGINT and SIGTERM into an orderly end."""

        def ask_to_stop(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
            name = signal.Signals(number).name
            self._quit_reason = "Ctrl-C in the terminal" if name == "SIGINT" else name

        before = {
            number: signal.signal(number, ask_to_stop) for number in (signal.SIGINT, signal.SIGTERM)
        }
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
