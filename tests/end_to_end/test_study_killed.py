"""The study killed at random instants while twelve robots run at 35 timesteps a second."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import sys
import time
import zlib
from pathlib import Path

import pytest
from mcap.reader import make_reader

from patience import PATIENCE_S
from protocols import ROOT, variant
from study.recording.reader import read_recording
from study.verification import verify

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals of Linux")

SESSION = ROOT / "tests" / "support" / "paced_session.py"
KILL_WITHIN_S = 2.0
SHORT_PHASES = (
    ("timesteps_per_second = 10.0", "timesteps_per_second = 35.0"),
    ("trials = 1\ntrial_timesteps = 40", "trials = 1\ntrial_timesteps = 4000"),
)
"""Twelve robots run for two minutes, so that each blow falls into a trial."""


def wait_until(awaited: str, since: float) -> None:
    assert time.monotonic() - since < PATIENCE_S, f"{awaited}: not within {PATIENCE_S:g} s"
    time.sleep(0.01)


def kill_one(folder: Path, seed: int) -> tuple[Path, Path]:
    """Begin a session, and kill it within two seconds after twelve robots run.

    Returns:
        The recording, and the log of what was accepted.
    """
    folder.mkdir()
    protocol = variant(folder, *SHORT_PHASES)
    study = subprocess.Popen(
        [sys.executable, str(SESSION), str(protocol), str(folder), str(seed)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    since = time.monotonic()
    try:
        while not (folder / "twelve_robots").exists():
            wait_until("twelve robots", since)
        time.sleep(random.Random(seed).uniform(0.0, KILL_WITHIN_S))
        assert study.poll() is None
    finally:
        study.kill()
        study.wait(PATIENCE_S)
    since = time.monotonic()
    while not (found := list((folder / "recordings").glob("*.mcap"))):
        wait_until("a finished recording", since)
    return found[0], folder / "accepted.log"


def accepted(log: Path) -> dict[int, tuple[str, int]]:
    """Return topic and checksum by number, as the log has them; a torn last line is none."""
    records: dict[int, tuple[str, int]] = {}
    text = log.read_text()
    for line in text[: text.rindex("\n")].splitlines():
        last, *noted = line.split()
        first = int(last) - len(noted) + 1
        for number, (topic, checksum) in enumerate((item.split(":") for item in noted), first):
            assert number not in records
            records[number] = (topic, int(checksum))
    return records


def check(path: Path, log: Path) -> None:
    """The file is whole and indexed, lacks nothing that was accepted, and replays to its end."""
    recording = read_recording(path)
    assert recording.complete, recording.problems
    oracle = accepted(log)
    found = {raw.sequence: (raw.topic, zlib.crc32(raw.data)) for raw in recording.raw()}
    assert sorted(found) == list(range(len(found)))
    assert {number: found[number] for number in oracle} == oracle
    # What was in flight may be there as well: handed over, and the study killed before the log.
    more = sorted(set(found) - set(oracle) - {0})
    assert more == list(range(len(oracle) + 1, len(oracle) + 1 + len(more)))
    inputs = [number for number in more if found[number][0].startswith("input/")]
    assert len(inputs) <= 1
    assert not more or inputs[:1] == more[:1] or len(more) == 1
    with path.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.chunk_indexes
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(found)
    verdict = verify(path)
    assert verdict.matches, verdict.difference


@pytest.fixture(scope="module")
def killed_once(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A recording of a killed study, and the log of what was accepted."""
    return kill_one(tmp_path_factory.mktemp("killed") / "blow", 1)


def test_a_killed_study_loses_nothing(tmp_path: Path, killed_once: tuple[Path, Path]) -> None:
    """Two blows at random instants: all that was accepted is in a whole file."""
    check(*killed_once)
    check(*kill_one(tmp_path / "blow", 2))


@pytest.mark.acceptance
@pytest.mark.timeout(7200)
def test_a_study_killed_a_hundred_times_loses_nothing(tmp_path: Path) -> None:
    """A hundred blows at random instants: all that was accepted is in whole files."""
    for blow in range(100):
        check(*kill_one(tmp_path / f"blow_{blow}", 1000 + blow))


def test_the_check_finds_what_is_missing(tmp_path: Path, killed_once: tuple[Path, Path]) -> None:
    """A log of more than the file holds is noticed."""
    path, given = killed_once
    log = Path(shutil.copy(given, tmp_path))
    with log.open("a") as stream:
        stream.write(f"{len(accepted(log)) + 10} event/timestep:1\n")
    with pytest.raises((AssertionError, KeyError)):
        check(path, log)
