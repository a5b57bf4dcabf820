"""Checks of what the participant will see: display, refresh rate, punctuality, letters."""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
import pygame

from study.events.fields import Record
from study.events.inputs import Input, TimestepDue
from study.events.shell import FrameIntervals
from study.screens import FleetScreen
from study.session.effects import SetPace
from study.shell.drawing.lettering import FILES, FONTS
from study.shell.live_loop import LiveClock, LiveLoop
from study.shell.preflight.check import Check, Limits
from study.shell.punctuality import LATE_PERIODS
from study.shell.window import SMALLEST, Window

TICK_S = 4.0
LATE_SHARE = Limits(amber=0.01, red=0.05)
SYNCHRONISED_FRAMES = 60
FASTEST_HZ = 400.0
"""Pictures that come faster than this are not waited for by the display."""
STEADY = 0.1
"""Middle half of the intervals, as a share of their median, where the display sets the pace."""
RATE_APART = 0.02
SECOND = 1_000_000_000


def refresh_rate(size: tuple[int, int] | None, *, fullscreen: bool) -> float:
    """Measure how often the display shows a picture, Hz; 0 where it does not say.

    Opens a window that waits for the display. It stays until the next one replaces it: some X
    servers start anew when their last window closes, and cannot be reached meanwhile.
    """
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    os.environ.setdefault("SDL_FRAMEBUFFER_ACCELERATION", "0")
    pygame.display.init()
    flags = pygame.SCALED | (pygame.FULLSCREEN if fullscreen else 0)
    shown: list[float] = []
    try:
        pygame.display.set_mode(size or (1280, 960), flags, vsync=1)
        until = time.perf_counter() + 1.5
        while len(shown) < SYNCHRONISED_FRAMES and time.perf_counter() < until:
            pygame.event.pump()
            pygame.display.flip()
            shown.append(time.perf_counter())
    except pygame.error:
        return 0.0
    # The first pictures fill the queue of the display without a wait.
    intervals = np.diff(shown)[5:]
    if not intervals.size:
        return 0.0
    low, middle, high = np.quantile(intervals, [0.25, 0.5, 0.75])
    waited = middle > 1 / FASTEST_HZ and high - low < STEADY * middle
    return float(1 / middle) if waited else 0.0


def display(window: Window, measured_hz: float) -> Check:
    """Check size and rate of the display.

    Args:
        window: open.
        measured_hz: what `refresh_rate` returned.
    """
    width, height = window.size
    stated = window.refresh_hz
    wanted = f"at least {SMALLEST[0]}x{SMALLEST[1]}; pictures as often as the display states"
    found = f"{width}x{height} under {window.driver}, states {stated:g} Hz"
    if width < SMALLEST[0] or height < SMALLEST[1]:
        return Check(name="display", state="red", found=found, wanted=wanted,
                     advice="Choose a higher resolution, or another display.")  # fmt: skip
    if not measured_hz:
        return Check(
            name="display", state="amber", found=f"{found}; its real rate cannot be measured",
            wanted=wanted,
            advice="Check the rate by hand: docs/how-to/check-a-seat.md.",
        )  # fmt: skip
    found += f", shows {measured_hz:.2f} Hz"
    if abs(measured_hz / stated - 1) > RATE_APART:
        return Check(name="display", state="red", found=found, wanted=wanted,
                     advice="Set the display to the rate that it can show.")  # fmt: skip
    return Check(name="display", state="green", found=found, wanted=wanted)


class _NoRecorder:
    """Nothing is recorded of a test, and nothing fails."""

    durable_sequence = sent_sequence = 0

    def check(self, now_ns: int) -> None:
        """Nothing fails."""

    def take_remarks(self) -> list[str]:
        """Nothing to remark."""
        return []


class _Rolling:
    """In place of a session: the robots of a screen roll on until time is up."""

    fleet_pending = fit_pending = False

    def __init__(self, screen: FleetScreen, rate: float, clock: LiveClock) -> None:
        self.screen = screen
        self.pace, self.pace_changed = SetPace(rate), True
        self.trial_id = 1
        self.intervals: list[npt.NDArray[np.float64]] = []
        self.finished = False
        self._clock = clock
        self._until_ns = clock.now() + round(TICK_S * SECOND)

    def observe(self, record: Record) -> None:
        """Keep the intervals between pictures."""
        if isinstance(record, FrameIntervals):
            self.intervals.append(record.intervals)

    def feed(self, given: Input) -> None:
        """Let the robots roll on."""
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


def punctuality(window: Window, screen: FleetScreen, rate: float) -> Check:
    """Run the study's own loop with the largest fleet of the protocol, and count late pictures.

    Args:
        window: open.
        screen: the fleet.
        rate: timesteps per second.
    """
    window.show(screen)
    window.draw(0)
    clock = LiveClock()
    rolling = _Rolling(dataclasses.replace(screen, t_ns=0), rate, clock)
    LiveLoop(rolling, window, _NoRecorder(), clock).run()  # type: ignore[arg-type]
    intervals = np.concatenate(rolling.intervals or [np.empty(0)])
    period = 1 / window.refresh_hz
    late = float(np.mean(intervals > LATE_PERIODS * period)) if intervals.size else 1.0
    hertz = 1 / float(intervals.mean()) if intervals.size else 0.0
    state = LATE_SHARE.state(late)
    return Check(
        name="punctuality",
        state=state,
        found=f"{hertz:.2f} pictures a second with {screen.robots} robots, {late:.1%} late",
        wanted=f"fewer than {LATE_SHARE.amber:.0%} late",
        advice="" if state == "green" else "End other programs; plug in the power cable.",
    )


def letters(texts: Iterable[str]) -> Check:
    """Check that the fonts are there and have every letter of the participant's texts."""
    needed = sorted({letter for text in texts for letter in text if letter.isprintable()} - {" "})
    missing: set[str] = set()
    wanted = "every letter of the study's texts in all three weights"
    for file in FILES.values():
        try:
            face = pygame.font.Font(FONTS / file, 20)
        except (OSError, pygame.error) as error:
            return Check(name="fonts", state="red", found=f"{file}: {error}", wanted=wanted,
                         advice="Install the program again: its fonts are missing.")  # fmt: skip
        metrics = face.metrics("".join(needed)) or []
        # A missing glyph has no outline.
        missing |= {
            letter
            for letter, outline in zip(needed, metrics, strict=False)
            if outline is None or not any(outline[:4])
        }
    if missing:
        return Check(
            name="fonts", state="red", found=f"no glyph for {' '.join(sorted(missing)[:20])}",
            wanted=wanted, advice="Write the texts without these letters.",
        )  # fmt: skip
    return Check(name="fonts", state="green", found=f"{len(needed)} letters in 3 weights",
                 wanted=wanted)  # fmt: skip
