"""Mutated recordings: no crash, no hang, no memory, and no value that is silently wrong."""

from __future__ import annotations

import multiprocessing
import random
import resource
import struct
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from patience import PATIENCE_S
from study.errors import RecordingError
from study.events.inputs import FleetObserved
from study.recording.client import Recorder
from study.recording.reader import RawRecord, Recording, read_recording
from study.recording.salvage import salvage

GOLDEN = Path(__file__).parent / "golden" / "v1.mcap"
SEED = 20
MEMORY_BYTES = 256 * 2**20
QUICK_S, NO_HANG_S = 1.0, 20.0
"""Seconds of computing that one file may take: on a machine of one's own, and on any."""

TOPIC = "input/fleet_observed"

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits memory as Linux does")


def small_recording(folder: Path) -> Path:
    """Write a recording of a dozen chunks and two fleet sizes."""
    recorder = Recorder.start(folder, "small", {"protocol.toml": b"a = 1\n" * 50}, {})
    generator = np.random.default_rng(1)
    for number in range(240):
        robots = 3 if number < 120 else 8
        record = FleetObserved(
            t_ns=number,
            request_id=number,
            robots=robots,
            states=generator.random((robots, 4)).astype(np.float32),
            rewards=np.zeros(robots, np.float32),
            outcomes=np.zeros(robots, np.int32),
            policy_actions=np.zeros(robots, np.int32),
            scores=generator.random(robots),
        )
        recorder.write(record, 1_000_000 + number)
        if number % 20 == 19:
            assert recorder.ensure_durable(PATIENCE_S)
    return recorder.close()


def record_places(data: bytes) -> list[int]:
    """Return where the records outside chunks begin."""
    places, position = [], 8
    while position + 9 <= len(data):
        places.append(position)
        position += 9 + int.from_bytes(data[position + 1 : position + 9], "little")
    return places


def mutated(data: bytes, generator: random.Random) -> bytes:
    """Return a copy with one to three mutations."""
    for _ in range(generator.choice([1, 1, 1, 2, 3])):
        data = mutate(data, generator)
    return data


def mutate(data: bytes, generator: random.Random) -> bytes:
    """Return a copy with one mutation."""
    spoiled = bytearray(data)
    place = generator.randrange(max(1, len(data)))
    length = generator.randrange(1, 400)
    other = generator.randrange(max(1, len(data)))
    kind = generator.randrange(8)
    if not data:
        return data
    if kind == 0:
        spoiled[place] ^= 1 << generator.randrange(8)
    elif kind == 1:
        spoiled[place : place + length] = generator.randbytes(len(spoiled[place : place + length]))
    elif kind == 2:
        del spoiled[place:]
    elif kind == 3:
        spoiled[place:place] = generator.randbytes(length)
    elif kind == 4:
        del spoiled[place : place + length]
    elif kind == 5:
        spoiled[other:other] = spoiled[place : place + length * 20]
    elif kind == 6:
        places = record_places(data)
        if len(places) > 3:
            first, second, third = sorted(generator.sample(places, 3))
            spoiled[first:third] = data[second:third] + data[first:second]
    else:
        places = record_places(data) or [0]
        at = generator.choice(places) + generator.choice([1, 9, 9 + 16, 9 + 32, 9 + 36, 9 + 44])
        size = generator.choice([0, 1, 2**31, 2**32 - 1, 2**62, 2**63, 2**64 - 1, len(data)])
        spoiled[at : at + 8] = struct.pack("<Q", size)
    return bytes(spoiled)


def accounted_for(found: Recording, full: dict[int, RawRecord]) -> str:
    """Return what is wrong with what was read, empty if nothing is."""
    left = {raw.sequence: raw for raw in found.raw()}
    for number, raw in left.items():
        if full.get(number) != raw:
            return f"record {number} differs"
    missing = [
        number
        for number in full.keys() - left.keys()
        if not any(loss.overlaps(number, number) for loss in found.losses)
    ]
    if missing:
        return f"records {sorted(missing)[:5]} are missing and not reported"
    if set(found.sequences.tolist()) != set(left):
        return "the numbers said to be held are not those held"
    for run in found.columns(TOPIC):
        numbers = run["sequence"].tolist()
        if any(full[number].topic != TOPIC for number in numbers):
            return "columns hold records of another topic"
    return ""


def check(
    source: bytes, full: dict[int, RawRecord], path: Path, cases: int, seed: int, limit: float
) -> list[str]:
    """Read mutated copies; return what went wrong."""
    generator = random.Random(seed)
    wrong: list[str] = []
    readable = 0
    for case in range(cases):
        data = mutated(source, generator)
        path.write_bytes(data)
        begun = time.process_time()
        try:
            found = read_recording(path)
            problem = accounted_for(found, full)
            if (
                not problem
                and data != source
                and found.complete
                and len(full) != len(found.sequences)
            ):
                problem = "it is said to be complete"
            readable += 1
            # Waiting for the disk takes most of the time, so not each time.
            if not problem and case % 4 == 0:
                new = path.with_name(f"{path.stem}_{case}.mcap")
                salvaged = read_recording(salvage(path, new).path)
                problem = accounted_for(salvaged, full)
                if not problem and salvaged.losses != found.losses:
                    problem = "the salvaged file tells other losses"
                new.unlink()
        except RecordingError:
            problem = ""
        except Exception as error:
            problem = repr(error)
        seconds = time.process_time() - begun
        if seconds > limit:
            problem = problem or f"took {seconds:.1f} s, not at most {limit:.1f} s"
        if problem:
            wrong.append(f"case {case} of seed {seed}: {problem}")
    if readable < cases // 2:
        wrong.append(f"only {readable} of {cases} files are readable")
    return wrong


def limited_worker(
    source: Path, folder: Path, cases: int, seed: int, limit: float, answers: object
) -> None:
    """Run `check` with little more memory than the process has already."""
    original = read_recording(source)
    full = {raw.sequence: raw for raw in original.raw()}
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY_BYTES, used + MEMORY_BYTES))
    wrong = check(source.read_bytes(), full, folder / "mutated.mcap", cases, seed, limit)
    answers.put(wrong)  # type: ignore[attr-defined]


def fuzz(source: Path, folder: Path, cases: int, seed: int, limit: float) -> list[str]:
    """Run a worker of its own for some cases; return what went wrong."""
    context = multiprocessing.get_context("spawn")
    answers = context.Queue()
    worker = context.Process(
        target=limited_worker, args=(source, folder, cases, seed, limit, answers)
    )
    worker.start()
    try:
        wrong: list[str] = answers.get(timeout=PATIENCE_S)
    finally:
        worker.join(PATIENCE_S)
        worker.kill()
    assert worker.exitcode == 0
    return wrong


@pytest.mark.parametrize("kind", ["small", "golden"])
def test_mutated_recordings(tmp_path: Path, kind: str) -> None:
    """Of 400 mutated files each value is right or reported as lost, and salvaged so."""
    source = small_recording(tmp_path) if kind == "small" else GOLDEN
    assert fuzz(source, tmp_path, 200, SEED, NO_HANG_S) == []


@pytest.mark.acceptance
def test_ten_thousand_mutated_recordings(tmp_path: Path) -> None:
    """The same of 10,000 mutated files, none of which takes over a second."""
    small = small_recording(tmp_path)
    wrong = []
    for batch in range(20):
        source = small if batch % 2 else GOLDEN
        wrong += fuzz(source, tmp_path, 500, 1000 + batch, QUICK_S)
    assert wrong == []


def test_the_check_finds_what_is_wrong(tmp_path: Path) -> None:
    """A file with other values than the original's is noticed."""
    recording = read_recording(small_recording(tmp_path))
    full = {raw.sequence: raw for raw in recording.raw()}
    assert accounted_for(recording, full) == ""
    assert "differs" in accounted_for(recording, full | {7: full[8]})
    assert "not reported" in accounted_for(recording, full | {999: full[8]})
