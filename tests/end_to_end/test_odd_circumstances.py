"""A real session while clocks jump, the computer stands still or is busy, and keys are mashed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from children import child_of
from onlooker import Onlooker
from patience import PATIENCE_S, until
from protocols import ROOT, variant
from real_study import close_last_words, real_study
from study.events.events import Deviation, Timestep
from study.events.inputs import KeyChanged
from study.events.shell import ClockPair
from study.recording.reader import Recording, read_recording
from study.recording.wire import decode
from study.screens import FleetScreen, PauseScreen
from study.verification import verify
from x11_driver import Hands

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a private X server, Linux signals")

LONG_PRACTICE = ("[practice]\ntimesteps = 10", "[practice]\ntimesteps = 9000")
STEP_NS = 100_000_000
MASHED = ("up", "left", "1", "down", "tab", "2", "right", "x", "3", "space", "4", "z")
"""None of them leaves the trial."""


@contextmanager
def practising(
    tmp_path: Path, program: tuple[str, ...] = ("-m", "study.commands.main")
) -> Iterator[tuple[Hands, subprocess.Popen[bytes], Callable[[int], None]]]:
    """Run a session up to its practice; yield what lets so many timesteps pass. Stop it then."""
    folder = tmp_path / "recordings"
    protocol = str(variant(tmp_path, LONG_PRACTICE))
    with real_study(protocol, folder, program=program) as (hands, study):
        onlooker = Onlooker(folder)
        hands.wait_for_window()
        while not isinstance(onlooker.look(), FleetScreen):
            hands.tap("return")
            time.sleep(0.2)

        def steps() -> int:
            if isinstance(onlooker.look(), PauseScreen):
                # A busy disk pauses; nobody asked for it.
                hands.tap("return")
                time.sleep(0.2)
            return sum(isinstance(event, Timestep) for event in onlooker.events)

        def run_on(more: int) -> None:
            wanted = steps() + more
            until(lambda: steps() >= wanted)

        run_on(3)
        yield hands, study, run_on
        run_on(3)
        assert study.poll() is None
        for key in ("escape", "q", "y"):
            hands.tap(key)
        # The session is over at the last key's press: its release, and what follows, is not of it.
        recorded_keys = hands.sent[:-1]
        assert close_last_words(hands, study) == 3
        hands.sent = recorded_keys


def recorded(tmp_path: Path) -> Recording:
    """Return the session's recording: one whole file, whose events replay."""
    (path,) = (tmp_path / "recordings").glob("*.mcap")
    recording = read_recording(path)
    assert recording.complete, recording.problems
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    # One clock gives all times: however the other one jumps, they lie as far apart as ever.
    # The writer's own first record, number 0, is none of the session's.
    records = [raw for raw in recording.raw() if raw.sequence]
    apart = {raw.log_time_ns - decode(raw.topic, raw.data).t_ns for raw in records}
    assert len(apart) == 1
    codes = [r.code for _, r in recording.records(Deviation.topic) if isinstance(r, Deviation)]
    assert set(codes) <= {"recording_interrupted", "ended_early"}
    return recording


def due_times(recording: Recording) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Return when the timesteps were begun, ns; there was no burst of them."""
    records = [record for _, record in recording.records(Timestep.topic)]
    due = np.array([r.due_ns for r in records if isinstance(r, Timestep)], dtype=np.int64)
    # Each takes a place of its own on the grid: what was missed is not caught up with.
    for steps in range(2, min(20, due.size)):
        assert (due[steps:] - due[:-steps]).min() > (steps - 1) * STEP_NS
    return due


def keys_of(recording: Recording) -> list[tuple[str, bool]]:
    records = [record for _, record in recording.records(KeyChanged.topic)]
    return [(record.key, record.down) for record in records if isinstance(record, KeyChanged)]


def test_a_wall_clock_that_jumps(tmp_path: Path) -> None:
    """Forwards and back by hours, each second: times stay in order, the jumps are on record."""
    program = (str(ROOT / "tests" / "support" / "odd_clock_study.py"),)
    with practising(tmp_path, program) as (_, _, run_on):
        # Both clocks are read together every ten seconds.
        run_on(210)
    recording = recorded(tmp_path)
    pairs = [r for _, r in recording.records(ClockPair.topic) if isinstance(r, ClockPair)]
    assert len(pairs) >= 3
    offsets = np.array([pair.utc_ns - pair.t_ns for pair in pairs]) / 1e9
    assert np.ptp(offsets) > 30
    assert np.diff(due_times(recording)).max() < 30e9


def test_a_computer_that_stands_still(tmp_path: Path) -> None:
    """As in a suspend, study and writer stop for seconds: no burst, one file, nothing lost."""
    with practising(tmp_path) as (_, study, run_on):
        writer = child_of(study, "study.recording.writer")  # type: ignore[arg-type]
        for process in (study.pid, writer):
            os.kill(process, signal.SIGSTOP)
        time.sleep(3.0)
        for process in (writer, study.pid):
            os.kill(process, signal.SIGCONT)
        run_on(5)
    assert np.diff(due_times(recorded(tmp_path))).max() > 2.9e9


def test_a_cpu_hog(tmp_path: Path) -> None:
    """Beside busy processes on every core each key is recorded, in order, and nothing is lost."""
    busy = (sys.executable, "-c", "while True: pass")
    with practising(tmp_path) as (hands, *_):
        hogs = [subprocess.Popen(busy) for _ in range(2 * (os.cpu_count() or 1))]
        try:
            for _ in range(30):
                for key in ("up", "left", "right"):
                    hands.tap(key)
        finally:
            for each in hogs:
                each.kill()
                each.wait()
        sent = list(hands.sent)
    recording = recorded(tmp_path)
    assert keys_of(recording)[: len(sent)] == sent
    assert due_times(recording).size > 9


def test_keys_mashed_at_1_khz(tmp_path: Path) -> None:
    """Three thousand key events in three seconds: each is recorded, and the trial goes on."""
    with practising(tmp_path) as (hands, _, run_on):
        begun = time.perf_counter()
        for number in range(3000):
            key = MASHED[number // 2 % len(MASHED)]
            hands.key(key, down=number % 2 == 0)
            time.sleep(max(0.0, begun + number / 1000 - time.perf_counter()))
        took = time.perf_counter() - begun
        run_on(5)
        sent = list(hands.sent)
    assert len(sent) > 3000
    assert took < 6.0 or os.getloadavg()[0] > (os.cpu_count() or 1), "that was not mashing"
    assert keys_of(recorded(tmp_path))[: len(sent)] == sent


FROM_THE_SHELL = (
    "import signal\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "from {package}.commands.starting import main\n"
    "main()\n"
)
"""As a program is started where Ctrl-C is not ignored."""


@pytest.mark.parametrize(
    ("package", "words"),
    [
        ("study", ("run", "smoke", "-p", "P01")),
        ("study", ("preflight", "smoke", "--no-keys")),
        ("analysis", ("report", "nowhere")),
    ],
)
def test_ctrl_c_at_any_moment_is_no_traceback(
    tmp_path: Path, package: str, words: tuple[str, ...]
) -> None:
    """While all is being imported, while processes begin, in the session: one line at most."""
    code = FROM_THE_SHELL.format(package=package)
    environment = {**os.environ, "SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy"}
    for delay in (0.15, 0.4, 0.8, 1.2, 1.6, 2.0, 2.6):
        output = ("-o", str(tmp_path / f"after {delay}"))
        program = subprocess.Popen(
            [sys.executable, "-c", code, *words, *output],
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        time.sleep(delay)
        if program.poll() is None:
            os.killpg(program.pid, signal.SIGINT)
        told = program.communicate(timeout=PATIENCE_S)[0]
        assert "Traceback" not in told, (delay, told)
        # Once Python itself is going, the signal ends it: to a shell that is 130 as well.
        assert program.returncode in (2, 3, 130, -signal.SIGINT), (delay, told)
