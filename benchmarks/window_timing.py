"""Punctuality of the participant's window, beside two loops that draw nothing, in one run.

    python benchmarks/window_timing.py --seconds 60

Starts a virtual X server (Xvfb) of 1920x1080, opens the window in it and runs, one after the other:
a bare loop on absolute deadlines, a loop on pygame's ``Clock.tick(60)``, and the program's own loop
with 12 and with 48 moving tiles. Another process presses real keys (XTEST) meanwhile. On a machine
that does other work read the numbers against the bare loop's.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]
os.environ["PYGAME_HIDE_SUPPORT_PROMPT"] = "1"

import pygame  # noqa: E402
from Xlib import XK, X  # noqa: E402
from Xlib.display import Display  # noqa: E402
from Xlib.ext import xtest  # noqa: E402

import sample_screens as samples  # noqa: E402
from study.events.inputs import Input, KeyChanged, TimestepDue  # noqa: E402
from study.shell.live_loop import LiveClock, LiveLoop  # noqa: E402
from study.shell.preflight.rolling import NoRecorder, Rolling  # noqa: E402
from study.shell.window import Window  # noqa: E402
from x11_driver import Hands as Server  # noqa: E402
from x11_driver import x_server  # noqa: E402

SIZE = (1920, 1080)
HZ = 60.0
LATE_PERIODS = 1.2
KEYS_PER_SECOND = 4.0
SECOND = 1_000_000_000


@dataclasses.dataclass
class Measured:
    """What one loop did.

    Attributes:
        name: of the loop.
        intervals: between pictures, s.
        latencies: from pressing a key to its handler, s.
        cpu: of the process for one picture, s.
        wall: of the whole, s.
    """

    name: str
    intervals: np.ndarray
    latencies: np.ndarray
    cpu: float
    wall: float

    def row(self) -> str:
        """Return the numbers as a line of the table."""
        period = 1 / HZ
        # A picture that is late, be it the first or the last, is no drift: the trend of all is.
        slots = np.cumsum(np.maximum(1, np.round(self.intervals / period)))
        shown = np.cumsum(self.intervals)
        drift = abs(float(np.polyfit(shown, shown - slots * period, 1)[0])) * self.wall
        late = np.mean(self.intervals > LATE_PERIODS * period)
        keys = f"{np.median(self.latencies) * 1e3:7.2f}" if self.latencies.size else "      -"
        return (
            f"{self.name:24}{1 / self.intervals.mean():8.3f}{drift / self.wall * 60e3:10.2f}"
            f"{np.quantile(self.intervals, 0.99) / period:9.3f}{late * 100:9.2f}{keys:>10}"
            f"{self.cpu * 1e3:10.2f}"
        )


HEADER = (
    f"{'loop':24}{'mean Hz':>8}{'drift/60s':>10}{'p99':>9}{'late %':>9}{'key ms':>10}"
    f"{'cpu ms':>10}\n"
    f"{'':24}{'':8}{'ms':>10}{'periods':>9}{'':9}{'median':>10}{'a frame':>10}"
)


class Hands:
    """Presses keys from another process; says when."""

    def __init__(self, display: str, seconds: float) -> None:
        command = [sys.executable, __file__, "--hands", display, "--seconds", str(seconds)]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)

    def times(self) -> list[int]:
        """Return when keys went down, ns of the monotonic clock."""
        out, _ = self._process.communicate(timeout=120)
        return [int(line) for line in out.split()]


def press_keys(display: str, seconds: float) -> None:
    """Press a key now and then; print when."""
    server = Display(display)
    code = server.keysym_to_keycode(XK.string_to_keysym("Up"))
    chance = random.Random(1)  # noqa: S311 - nothing secret
    until = time.perf_counter() + seconds - 0.5
    while time.perf_counter() < until:
        time.sleep(chance.uniform(0.5, 1.5) / KEYS_PER_SECOND)
        print(time.perf_counter_ns())
        for kind in (X.KeyPress, X.KeyRelease):
            xtest.fake_input(server, kind, code)
            server.sync()


def latencies(pressed: list[int], handled: list[int]) -> np.ndarray:
    """Return the times from pressing to handling, s; unhandled presses are left out."""
    found = []
    waiting = list(handled)
    for at in pressed:
        while waiting and waiting[0] < at:
            waiting.pop(0)
        if waiting:
            found.append((waiting.pop(0) - at) / SECOND)
    return np.array(found)


def plain_loop(name: str, display: str, seconds: float, *, deadlines: bool) -> Measured:
    """Run a loop that draws nothing: on absolute deadlines, or on pygame's clock."""
    pygame.display.init()
    pygame.display.set_mode(SIZE)
    focus(display)
    hands = Hands(display, seconds)
    clock = pygame.time.Clock()
    shown, handled = [], []
    began, cpu = time.perf_counter_ns(), time.process_time()
    period = round(SECOND / HZ)
    due = began

    def take(event: pygame.event.Event) -> None:
        if event.type == pygame.KEYDOWN:
            handled.append(time.perf_counter_ns())

    while (now := time.perf_counter_ns()) < began + seconds * SECOND:
        if not deadlines:
            for event in pygame.event.get():
                take(event)
            pygame.display.flip()
            clock.tick(HZ)
            shown.append(time.perf_counter_ns())
            continue
        if now >= due:
            pygame.display.flip()
            shown.append(time.perf_counter_ns())
            due += period * max(1, -(-(now - due) // period))
        left = (due - time.perf_counter_ns()) // 1_000_000
        if left >= 1:
            event = pygame.event.wait(left)
            if event.type != pygame.NOEVENT:
                take(event)
        else:
            time.sleep(max(0, due - time.perf_counter_ns()) / SECOND)
        for event in pygame.event.get():
            take(event)
    cpu = (time.process_time() - cpu) / max(1, len(shown))
    wall = (time.perf_counter_ns() - began) / SECOND
    pygame.display.quit()
    return Measured(name, np.diff(shown) / SECOND, latencies(hands.times(), handled), cpu, wall)


class Driving(Rolling):
    """Robots that roll on at 8 timesteps a second, and lose health, until time is up."""

    def __init__(self, robots: int, seconds: float, clock: LiveClock) -> None:
        super().__init__(samples.fleet(robots, operated=4), 8.0, seconds, clock)
        self.handled: list[int] = []

    def feed(self, given: Input) -> None:
        """Note a key; move the robots."""
        super().feed(given)
        if isinstance(given, KeyChanged) and given.down:
            self.handled.append(time.perf_counter_ns())
        if isinstance(given, TimestepDue):
            self.screen = dataclasses.replace(
                self.screen,
                tiles=tuple(
                    dataclasses.replace(tile, health=max(5.0, tile.health - 0.2))
                    for tile in self.screen.tiles
                ),
                seconds_left=max(0.0, self.screen.seconds_left - 0.125),
            )


def window_loop(robots: int, display: str, seconds: float) -> Measured:
    """Run the program's own loop and window."""
    window = Window(SIZE)
    focus(display)
    clock = LiveClock()
    driving = Driving(robots, seconds, clock)
    # The first picture paints all that is kept afterwards; a session's ready page precedes it.
    window.show(driving.screen)
    window.draw(0)
    hands = Hands(display, seconds)
    clock = LiveClock()
    driving = Driving(robots, seconds, clock)
    began, cpu = time.perf_counter(), time.process_time()
    LiveLoop(driving, window, NoRecorder(), clock).run()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - began
    window.close()
    intervals = np.concatenate(driving.intervals)
    pressed = latencies(hands.times(), driving.handled)
    return Measured(f"{robots} tiles", intervals, pressed, cpu / intervals.size, wall)


def focus(display: str) -> None:
    """Give the window the keyboard: there is no window manager."""
    server = Server(display)
    server.wait_for_window()
    server.close()


def main() -> int:
    """Run all loops and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--hands", default="", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.hands:
        press_keys(given.hands, given.seconds)
        return 0

    with x_server(*SIZE) as display:
        os.environ.update(DISPLAY=display, SDL_VIDEODRIVER="x11", SDL_FRAMEBUFFER_ACCELERATION="0")
        found = [plain_loop("bare loop", display, given.seconds, deadlines=True)]
        found.append(plain_loop("Clock.tick(60)", display, given.seconds, deadlines=False))
        found += [window_loop(robots, display, given.seconds) for robots in (12, 48)]
    load = os.getloadavg()[0] / (os.cpu_count() or 1)
    print(f"{SIZE[0]}x{SIZE[1]}, {given.seconds:g} s each, load {load:.1f} a core\n{HEADER}")
    for measured in found:
        print(measured.row())
    bare, *_, twelve, forty = found
    for own in (twelve, forty):
        period = 1 / HZ
        p99, least = (float(np.quantile(m.intervals, 0.99)) for m in (own, bare))
        late, base = (float(np.mean(m.intervals > LATE_PERIODS * period)) for m in (own, bare))
        print(
            f"{own.name}: p99 {p99 / least:.3f} of the bare loop's, late frames "
            f"{(late - base) * 100:+.2f} percentage points against it"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
