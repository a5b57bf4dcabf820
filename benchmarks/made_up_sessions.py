"""Sessions made of random numbers, in our format and as naive JSON, for the benchmarks."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import Writer

from study.events.events import Timestep
from study.recording.client import Recorder

RATE = 35
"""Timesteps per second."""

HALF_HOUR = 30 * 60 * RATE
START_NS = 1_800_000_000_000_000_000
ROBOT_FIELDS = (
    "actions",
    "action_sources",
    "rewards",
    "outcomes",
    "available",
    "scores",
)


def timesteps(robots: int, count: int, seed: int = 0) -> Iterator[Timestep]:
    """Yield timesteps of robots that wander about."""
    random = np.random.default_rng(seed)
    states = random.random((robots, 4), np.float32)
    none = np.zeros(robots, np.int32)
    for number in range(count):
        states = states + random.normal(0.0, 0.02, (robots, 4)).astype(np.float32)
        t_ns = number * 1_000_000_000 // RATE
        yield Timestep(
            t_ns=t_ns,
            due_ns=t_ns,
            trial_id=number // 2_000,
            timestep=number % 2_000,
            robots=robots,
            operated=number % robots,
            choice_source=0,
            choice_flag=0,
            states=states,
            actions=random.integers(0, 5, robots).astype(np.int32),
            action_sources=none,
            rewards=random.normal(size=robots).astype(np.float32),
            outcomes=none,
            available=none + 1,
            scores=random.normal(size=robots),
        )


def as_json(record: Timestep) -> bytes:
    """Encode a timestep as one would without thinking: an object for each robot."""
    rows: dict[str, list[Any]] = {name: getattr(record, name).tolist() for name in ROBOT_FIELDS}
    return json.dumps(
        {
            "t_ns": record.t_ns,
            "due_ns": record.due_ns,
            "trial_id": record.trial_id,
            "timestep": record.timestep,
            "operated": record.operated,
            "choice_source": record.choice_source,
            "choice_flag": record.choice_flag,
            "robots": [
                {
                    "x": state[0],
                    "y": state[1],
                    "heading": state[2],
                    "health": state[3],
                    **{name: rows[name][robot] for name in ROBOT_FIELDS},
                }
                for robot, state in enumerate(record.states.tolist())
            ],
        }
    ).encode()


def write_ours(folder: Path, name: str, robots: int, count: int, seed: int = 0) -> Path:
    """Record a session with our recorder, in chunks of half a second as real ones have.

    Returns:
        The file.
    """
    recorder = Recorder.start(folder, name, {}, {"session_id": name}, batch_bytes=1 << 16)
    for number, record in enumerate(timesteps(robots, count, seed), start=1):
        recorder.write(record, START_NS + record.t_ns)
        if number % (RATE // 2) == 0 and not recorder.ensure_durable(30):
            raise SystemExit("The disk did not answer within 30 s.")
    return recorder.close()


def json_writer(stream: Any) -> tuple[Writer, int]:  # noqa: ANN401 - mcap's Writer is untyped
    """Return mcap's writer as it comes, and the channel of the timesteps."""
    writer = Writer(stream)
    writer.start()
    schema = writer.register_schema("timestep", "jsonschema", b'{"type": "object"}')
    return writer, writer.register_channel("timestep", "json", schema)


def write_json(path: Path, robots: int, count: int, seed: int = 0) -> Path:
    """Record the same session as JSON with mcap's own writer; return the file."""
    with path.open("wb") as stream:
        writer, channel = json_writer(stream)
        for record in timesteps(robots, count, seed):
            time_ns = START_NS + record.t_ns
            writer.add_message(channel, time_ns, as_json(record), time_ns)
        writer.finish()
    return path


def machine() -> str:
    """Return, on a line, what the numbers were measured on."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "mcap", "pandas"))
    return (
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, "
        f"{packages}"
    )
