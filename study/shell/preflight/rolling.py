"""Robots that roll on by themselves, in place of a session: to see how punctual a window is."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from study.events.fields import Record
from study.events.inputs import Input, QuitRequested, TimestepDue
from study.events.shell import FrameIntervals
from study.screens import FleetScreen
from study.session.effects import SetPace
from study.shell.live_loop import LiveClock

SECOND = 1_000_000_000


class NoRecorder:
    """Nothing is recorded of a test, and nothing fails."""

    durable_sequence = sent_sequence = 0

    def check(self, now_ns: int) -> None:
        """Nothing fails."""

    def take_remarks(self) -> list[str]:
        """Nothing to remark."""
        return []


class Rolling:
    """In place of a session: the robots of a screen roll on until time is up."""

    fleet_pending = fit_pending = False

    def __init__(self, screen: FleetScreen, rate: float, seconds: float, clock: LiveClock) -> None:
        self.screen = screen
        self.pace, self.pace_changed = SetPace(rate), True
        self.trial_id = 1
        self.intervals: list[npt.NDArray[np.float64]] = []
        self.finished = False
        self._clock = clock
        self._until_ns = clock.now() + round(seconds * SECOND)

    def observe(self, record: Record) -> None:
        """Keep the intervals between pictures."""
        if isinstance(record, FrameIntervals):
            self.intervals.append(record.intervals)

    def feed(self, given: Input) -> None:
        """Let the robots roll on.

        Raises:
            KeyboardInterrupt: by Ctrl-C, or as the window is closed: no other check is wanted.
        """
        if isinstance(given, QuitRequested):
            raise KeyboardInterrupt(given.reason)
        if not isinstance(given, TimestepDue):
            return
        screen = self.screen
        scene = screen.scene
        tiles = tuple(
            dataclasses.replace(
                tile,
                x=(tile.x + 0.25 * math.cos(tile.heading)) % scene.width,
                y=(tile.y + 0.25 * math.sin(tile.heading)) % scene.height,
                heading=tile.heading + 0.1,
            )
            for tile in screen.tiles
        )
        self.screen = dataclasses.replace(
            screen, tiles=tiles, timestep=screen.timestep + 1, t_ns=given.t_ns
        )

    def collect(self, *_: object) -> bool:
        """Nothing is awaited; time goes on."""
        self.finished = self._clock.now() >= self._until_ns
        return False
