"""Markers of a session for Lab Streaming Layer: what is published, when, and what may fail."""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from patience import PATIENCE_S
from protocols import ROOT
from study.events.codes import ChoiceSource
from study.events.events import Event, Switched, TrialEnded, TrialStarted
from study.events.fields import Record
from study.events.shell import LslClockPair, Note, ShellObservation
from study.recording.reader import Recording, read_recording
from study.shell.markers import MARKED, MarkerPublisher, marker

SUPPORT = ROOT / "tests" / "support"


class StandIn:
    """An outlet that keeps what it is given; its clock is five seconds before the session's."""

    def __init__(self, session_ns: Iterator[int]) -> None:
        self.session_ns = session_ns
        self.pushed: list[tuple[float, str]] = []
        self.broken = False

    def clock(self) -> float:
        """Return the clock."""
        return next(self.session_ns) / 1e9 - 5

    def push(self, marker: str, at_seconds: float) -> None:
        """Keep a marker."""
        if self.broken:
            raise OSError("the cable is out")
        self.pushed.append((at_seconds, marker))

    def close(self) -> None:
        """Do nothing."""


def switched(t_ns: int) -> Switched:
    """Return a takeover."""
    return Switched(t_ns, 3, 7, -1, 2, int(ChoiceSource.OPERATOR), "number")


def started() -> TrialStarted:
    """Return a trial's beginning, which has an array."""
    texts: Any = {"condition": "manual", "allocation": "manual", "view": "tiles"}
    numbers: Any = {"trial_id": 3, "phase": 3, "block": 1, "trial": 1, "robots": 2, "timesteps": 9}
    states = np.ones((2, 4), np.float32)
    return TrialStarted(
        t_ns=5, **texts, **numbers, dwell=0, policy_id="p", scorer_id="", scored=True, states=states
    )


def test_a_marker_is_the_event_without_its_arrays() -> None:
    """Topic, number and fields are the recording's; NaN, which JSON does not have, is null."""
    found = json.loads(marker(42, started()))
    assert (found["topic"], found["sequence"], found["t_ns"]) == ("event/trial_started", 42, 5)
    assert (found["condition"], found["scored"], found["robots"]) == ("manual", True, 2)
    assert "states" not in found
    ended = marker(43, TrialEnded(6, 3, 9, float("nan"), complete=False))
    assert json.loads(ended)["team_reward"] is None
    assert "NaN" not in ended


def test_markers_are_stamped_by_the_pair_recorded() -> None:
    """A marker has its event's time, mapped by a pair of readings at most ten seconds old."""
    now = itertools.count(1_000_000_000, 1_000)
    outlet = StandIn(now)
    observed: list[ShellObservation] = []
    publisher = MarkerPublisher(outlet, lambda: next(now), observed.append)
    publisher.publish([(1, switched(900_000_000)), (2, switched(999_000_000))])
    (pair,) = observed
    assert isinstance(pair, LslClockPair)
    assert pair.uncertainty_ns == 2_000
    assert pair.lsl_seconds == pytest.approx(pair.t_ns / 1e9 - 5, abs=1e-9)
    stamps = [stamp for stamp, _ in outlet.pushed]
    assert stamps == pytest.approx([-4.1, -4.001], abs=1e-9)
    outlet.session_ns = now = itertools.count(12_000_000_000, 1_000)
    publisher._now = lambda: next(now)
    publisher.publish([(3, switched(12_000_000_000))])
    assert len(observed) == 2


def test_a_failure_is_noted_once_and_costs_nothing() -> None:
    """An outlet that fails ends the markers, not the session; the recording says why."""
    outlet = StandIn(itertools.count(0, 1_000))
    observed: list[ShellObservation] = []
    publisher = MarkerPublisher(outlet, lambda: 0, observed.append)
    outlet.broken = True
    for number in range(3):
        publisher.publish([(number, switched(number))])
    notes = [record for record in observed if isinstance(record, Note)]
    assert [note.text for note in notes] == [
        "no more markers are published: OSError: the cable is out"
    ]
    assert publisher.failure


@pytest.mark.parametrize(
    ("source", "named"),
    [
        ("raise ImportError('no module')", "pip install 'scaled-autonomy[lsl]'"),
        ("raise RuntimeError('LSL binary library file was not found.')", "liblsl"),
    ],
    ids=["pylsl", "liblsl"],
)
def test_what_is_missing_is_said_before_the_session(
    tmp_path: Path, source: str, named: str
) -> None:
    """Without pylsl or liblsl one message says what to install; nothing is begun."""
    (tmp_path / "pylsl.py").write_text(source, encoding="utf-8")
    folder = tmp_path / "recordings"
    done = subprocess.run(
        command(folder),
        env={**environment(tmp_path), "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 2
    words = " ".join(done.stderr.split())
    assert named in words
    assert "Traceback" not in words
    # No slot is taken either.
    assert not folder.exists()


def command(folder: Path) -> list[str]:
    """Return what starts a session with markers."""
    program = [sys.executable, "-m", "study.commands.main", "run", "protocols/smoke.toml"]
    return [*program, "-p", "P01", "-o", str(folder), "--lsl"]


def environment(folder: Path) -> dict[str, str]:
    """Return an environment in which Lab Streaming Layer stays on this machine."""
    settings = folder / "lsl_api.cfg"
    settings.write_text(
        "[ports]\nIPv6 = disable\n[multicast]\nResolveScope = machine\n"
        f"[lab]\nKnownPeers = {{127.0.0.1}}\nSessionID = {folder.name}_{os.getpid()}\n"
        "[log]\nlevel = -2\n",
        encoding="utf-8",
    )
    return {
        **os.environ,
        "LSLAPICFG": str(settings),
        "SDL_VIDEODRIVER": "dummy",
        "SDL_AUDIODRIVER": "dummy",
        "PYTHONPATH": f"{ROOT}{os.pathsep}{SUPPORT}",
    }


@contextmanager
def receiving(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Start an inlet in another process, and make sure that it ends."""
    process = subprocess.Popen(
        [sys.executable, str(SUPPORT / "lsl_inlet.py"), str(folder / "received.jsonl")],
        env=environment(folder),
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.wait(10)
        if process.stdout:
            process.stdout.close()


def received(folder: Path) -> list[tuple[float, dict[str, Any]]]:
    """Return the markers that came, with their times."""
    lines = (folder / "received.jsonl").read_text(encoding="utf-8").splitlines()
    return [(stamp, json.loads(text)) for stamp, text in map(json.loads, lines)]


def marked(recording: Recording) -> list[tuple[int, Event]]:
    """Return the recording's events that have a marker."""
    topics = [kind.topic for kind in MARKED]
    return [(n, event) for n, event in recording.records(*topics) if isinstance(event, MARKED)]


def assert_agree(recording: Recording, came: list[tuple[float, dict[str, Any]]], skip: int) -> None:
    """Each marker is an event of the recording, all from the given one on, at its time."""
    expected = marked(recording)[skip:]
    assert [text for _, text in came] == [json.loads(marker(n, event)) for n, event in expected]
    pairs: list[Record] = [record for _, record in recording.records(LslClockPair.topic)]
    assert pairs
    for (stamp, _), (_, event) in zip(came, expected, strict=True):
        mapped = [
            pair.lsl_seconds + (event.t_ns - pair.t_ns) / 1e9
            for pair in pairs
            if isinstance(pair, LslClockPair)
        ]
        assert min(abs(stamp - each) for each in mapped) < 1e-6


def test_an_inlet_receives_a_whole_session(tmp_path: Path) -> None:
    """Trials, takeovers and surveys of a simulated session arrive elsewhere, one to one."""
    folder = tmp_path / "recordings"
    with receiving(tmp_path) as inlet:
        driven = subprocess.run(
            [sys.executable, str(SUPPORT / "lsl_session.py"), str(folder)],
            env=environment(tmp_path),
            cwd=ROOT,
            check=False,
            timeout=PATIENCE_S,
        )
        assert driven.returncode == 0
        assert inlet.wait(60) == 0
    (path,) = folder.glob("*.mcap")
    recording = read_recording(path)
    assert_agree(recording, received(tmp_path), skip=0)
    topics = {event.topic for _, event in marked(recording)}
    wanted = {"trial_started", "trial_ended", "switched", "question_answered", "session_ended"}
    assert {f"event/{name}" for name in wanted} <= topics


@pytest.mark.skipif(sys.platform != "linux", reason="a signal of Linux ends the session")
def test_study_run_publishes(tmp_path: Path) -> None:
    """`study run --lsl` in a window: from when the inlet is there, every marker arrives."""
    folder = tmp_path / "recordings"
    study = subprocess.Popen(command(folder), env=environment(tmp_path), cwd=ROOT)
    try:
        with receiving(tmp_path) as inlet:
            assert inlet.stdout is not None
            assert inlet.stdout.readline().startswith("ready")
            deadline = time.monotonic() + PATIENCE_S
            while not list(folder.glob("*.part")):
                assert time.monotonic() < deadline, "the session did not begin"
                time.sleep(0.1)
            time.sleep(2)
            study.send_signal(signal.SIGTERM)
            assert study.wait(60) == 3
            assert inlet.wait(60) == 0
    finally:
        study.kill()
        study.wait(10)
    (path,) = folder.glob("*.mcap")
    recording, came = read_recording(path), received(tmp_path)
    assert_agree(recording, came, skip=len(marked(recording)) - len(came))
    assert [text["topic"] for _, text in came][-2:] == ["event/deviation", "event/session_ended"]


def test_pylsl_is_loaded_on_request_only() -> None:
    """Without --lsl nothing of it is loaded."""
    code = "import sys, study.commands.running; print('pylsl' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip().endswith("False")
