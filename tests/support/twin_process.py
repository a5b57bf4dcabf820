"""A digital twin in a process of its own, for tests."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from study.robots.client import RobotAddress, RobotClient
from study.robots.fleet import RobotFleet
from study.robots.keys import OPERATOR, make_keys, read_pair
from study.robots.link import Transport, Wrap
from study.robots.poses import TwinPoses
from study.robots.safety import USUAL_BOUNDS, Bounds
from study.robots.twin import MOTION_CAPTURE, robot_name

ROOT = Path(__file__).resolve().parents[2]


def twin_keys(folder: Path, robots: int) -> Path:
    """Make the keys of a twin; return their folder."""
    make_keys(folder, [OPERATOR, MOTION_CAPTURE, *map(robot_name, range(robots))])
    return folder


class TwinProcess:
    """A running twin; killed at the end."""

    def __init__(self, keys: Path, robots: int, port: int = 0) -> None:
        command = [sys.executable, "-m", "study.robots.twin"]
        options = ["--keys", str(keys), "--robots", str(robots), "--port", str(port)]
        self.robots_file = keys.parent / "robots.toml"
        options += ["--write", str(self.robots_file)]
        self.keys = keys
        self.process = subprocess.Popen(
            [*command, *options],
            cwd=ROOT,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        ready, _, _ = select.select([self.process.stdout], [], [], 30)
        assert ready, "the twin did not start"
        self.where: dict[str, Any] = json.loads(self.process.stdout.readline())

    def tell(self, line: str) -> None:
        """Give it a line of standard input."""
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def kill(self) -> None:
        """End it without warning."""
        self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout):
            if stream is not None:
                stream.close()

    def addresses(self) -> list[RobotAddress]:
        """Return where its robots are."""
        return [RobotAddress(**robot) for robot in self.where["robots"]]

    def client(self, robot: int, wrap: Wrap = lambda transport: transport) -> RobotClient:
        """Return the operator's end of the link to one robot."""
        return RobotClient(self.addresses()[robot], read_pair(self.keys / f"{OPERATOR}.toml"), wrap)

    def poses(self) -> TwinPoses:
        """Return its motion capture."""
        where = self.where["poses"]
        keys = read_pair(self.keys / f"{OPERATOR}.toml")
        return TwinPoses(where["address"], where["public_key"], keys)

    def fleet(self, bounds: Bounds = USUAL_BOUNDS) -> RobotFleet:
        """Return all its robots, not yet connected."""
        clients = [self.client(robot) for robot in range(len(self.where["robots"]))]
        return RobotFleet(clients, self.poses(), bounds)


@contextmanager
def running_twin(folder: Path, robots: int) -> Iterator[TwinProcess]:
    """Make keys, start a twin, kill it at the end."""
    twin = TwinProcess(twin_keys(folder, robots), robots)
    try:
        yield twin
    finally:
        twin.kill()


def wait_until(holds: Callable[[], bool], timeout_s: float = 5.0) -> float:
    """Wait for something; return how long it took, seconds."""
    began = time.monotonic()
    while not holds():
        assert time.monotonic() < began + timeout_s, "it did not happen"
        time.sleep(0.002)
    return time.monotonic() - began


class Worse:
    """A transport that a test makes worse while it is used."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self.change: Callable[[list[list[bytes]]], list[list[bytes]]] = lambda sent: sent
        self._kept: list[list[bytes]] = []
        self.delay_s = 0.0
        self._late: list[tuple[float, list[bytes]]] = []

    def send(self, parts: Sequence[bytes]) -> None:
        """Send what is left of it, when it is due."""
        now = time.monotonic()
        self._late += [(now + self.delay_s, kept) for kept in self.change([list(parts)])]
        self._flush(now)

    def receive(self) -> list[bytes] | None:
        """Return what has come."""
        self._flush(time.monotonic())
        return self._transport.receive()

    def _flush(self, now: float) -> None:
        due = [parts for at, parts in self._late if at <= now]
        self._late = [(at, parts) for at, parts in self._late if at > now]
        for parts in due:
            self._transport.send(parts)
