"""Checks of what the participant will see: display, refresh rate, punctuality, letters."""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Iterable

import numpy as np
import pygame

from study.preflight_result import Check, Limits
from study.screens import FleetScreen
from study.shell.drawing.faces import FILES, FONTS, OTHER_FILES
from study.shell.drawing.fallback import lacking
from study.shell.interrupts import ctrl_c_later
from study.shell.live_loop import LiveClock, LiveLoop
from study.shell.preflight.rolling import NoRecorder, Rolling
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
        with ctrl_c_later():
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
    rolling = Rolling(dataclasses.replace(screen, t_ns=0), rate, TICK_S, clock)
    LiveLoop(rolling, window, NoRecorder(), clock).run()  # type: ignore[arg-type]
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
    read = list(texts)
    wanted = "every letter of the study's texts in all three weights"
    for file in (*FILES.values(), *sorted(set(OTHER_FILES.values()))):
        try:
            pygame.font.Font(FONTS / file, 20)
        except (OSError, pygame.error) as error:
            return Check(name="fonts", state="red", found=f"{file}: {error}", wanted=wanted,
                         advice="Install the program again: its fonts are missing.")  # fmt: skip
    needed = {letter for text in read for letter in text if letter.isprintable()} - {" "}
    missing = {letter for text in read for weight in FILES for letter in lacking(text, weight)}
    if missing:
        return Check(
            name="fonts", state="red", found=f"no glyph for {' '.join(sorted(missing)[:20])}",
            wanted=wanted, advice="Write the texts without these letters.",
        )  # fmt: skip
    return Check(name="fonts", state="green", found=f"{len(needed)} letters in 3 weights",
                 wanted=wanted)  # fmt: skip
