"""The writer killed at random instants of a session of twelve robots."""

from __future__ import annotations

import dataclasses
import os
import random
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from patience import PASS_S
from recording_parts import Merged
from study.events.events import Timestep
from study.events.fields import Record
from study.events.inputs import RecordingInterrupted, RecordingRestored
from study.recording.failover import FailoverRecorder
from study.recording.reader import read_recording
from study.recording.wire import encode

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals of Linux")

TIMESTEPS_PER_SECOND = 35
ROBOTS = 12


@dataclasses.dataclass
class Accepted:
    """An independent log of what a recorder accepted: topic, log time and bytes by number."""

    recorder: FailoverRecorder
    log: dict[int, tuple[str, int, bytes]] = dataclasses.field(default_factory=dict)

    def write(self, record: Record) -> None:
        """Hand a record over, and note it."""
        log_time_ns = time.time_ns()
        sequence = self.recorder.write(record, log_time_ns)
        assert sequence not in self.log
        self.log[sequence] = (record.topic, log_time_ns, encode(record))


def timestep(number: int, generator: np.random.Generator) -> Timestep:
    return Timestep(
        t_ns=time.perf_counter_ns(),
        due_ns=0,
        trial_id=0,
        timestep=number,
        robots=ROBOTS,
        operated=0,
        choice_source=0,
        choice_flag=0,
        states=generator.random((ROBOTS, 4)).astype(np.float32),
        actions=np.zeros(ROBOTS, np.int32),
        action_sources=np.zeros(ROBOTS, np.int32),
        rewards=np.zeros(ROBOTS, np.float32),
        outcomes=np.zeros(ROBOTS, np.int32),
        available=np.ones(ROBOTS, np.int32),
        scores=generator.random(ROBOTS),
    )


def run(folder: Path, kills: int, seed: int) -> tuple[Accepted, list[Path], list[float]]:
    """Stream timesteps on the clock; kill or stop the writer now and then.

    Returns:
        The log, the parts, and how long after each blow it was noticed, seconds.
    """
    chance, generator = random.Random(seed), np.random.default_rng(seed)
    recorder = FailoverRecorder.start(folder, "killed", {}, {"session_id": "s"})
    accepted = Accepted(recorder)
    noticed: list[float] = []
    struck, since, due = False, 0.0, time.perf_counter()
    passed = due
    strike_at = due + chance.uniform(0.0, 1.0)
    number = 0
    while len(noticed) < kills:
        now = time.perf_counter()
        # A pass in which the machine did other things counts as one that it did not.
        since += min(now - passed, PASS_S)
        passed = now
        if not struck and now >= strike_at:
            blow = signal.SIGSTOP if chance.random() < 0.2 else signal.SIGKILL
            struck, since = True, 0.0
            os.kill(recorder.writer_pid, blow)
        fault = recorder.check(time.perf_counter_ns())
        if fault is not None:
            noticed.append(since)
            accepted.write(RecordingInterrupted(time.perf_counter_ns(), fault))
            part = recorder.begin_part(fault)
            accepted.write(RecordingRestored(time.perf_counter_ns(), part))
            struck, strike_at = False, time.perf_counter() + chance.uniform(0.0, 1.0)
        if now >= due:
            accepted.write(timestep(number, generator))
            number += 1
            due = max(due + 1 / TIMESTEPS_PER_SECOND, now)
        time.sleep(0.002)
    return accepted, recorder.close(), noticed


def check(folder: Path, kills: int, seed: int) -> None:
    accepted, paths, noticed = run(folder, kills, seed)
    merged = Merged(paths)
    found = {row.sequence: (row.topic, row.log_time_ns, row.data) for row in merged.raw()}
    assert found == accepted.log
    assert sorted(found) == list(range(1, len(found) + 1))
    assert len(paths) == kills + 1
    assert all(seconds < 1.05 for seconds in noticed), noticed
    assert [path.name.endswith(".part") for path in paths] == [True] * kills + [False]
    assert read_recording(paths[-1]).complete


def test_killing_the_writer_loses_nothing(tmp_path: Path) -> None:
    """Five blows at random instants: across the parts every accepted record is there."""
    check(tmp_path, 5, seed=1)


@pytest.mark.acceptance
@pytest.mark.timeout(3600)
def test_killing_the_writer_a_hundred_times_loses_nothing(tmp_path: Path) -> None:
    """A hundred blows at random instants: across the parts every accepted record is there."""
    check(tmp_path, 100, seed=2)
