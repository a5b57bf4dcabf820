"""Poses from NatNet, against a server that speaks it over UDP."""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Iterator

import pytest

from extras import need
from natnet_server import NatNetServer
from study.errors import StudyError
from study.robots.poses import NatNetPoses
from twin_process import wait_until

need("natnet", "zmq")

QUARTER = math.sin(math.pi / 4)


@pytest.fixture
def server() -> Iterator[NatNetServer]:
    """Motive, as far as we need it."""
    made = NatNetServer()
    yield made
    made.close()


def source(server: NatNetServer, **how: object) -> NatNetPoses:
    """Return a source that knows bodies 11 and 12 as robots 0 and 1."""
    ports = (server.port, server.port)
    return NatNetPoses("127.0.0.1", "127.0.0.1", {11: 0, 12: 1}, ports=ports, **how)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("up", "place", "turn"),
    [
        ("z", (1.5, 2.5, 0.1), (0.0, 0.0, QUARTER, QUARTER)),
        ("y", (1.5, 0.1, -2.5), (0.0, QUARTER, 0.0, QUARTER)),
    ],
)
def test_bodies_become_poses(
    server: NatNetServer,
    up: str,
    place: tuple[float, float, float],
    turn: tuple[float, float, float, float],
) -> None:
    """A quarter turn to the left about the axis that points up, in either of Motive's frames."""
    server.bodies = {11: (place, turn, True), 99: ((9.0, 9.0, 9.0), (0.0, 0.0, 0.0, 1.0), True)}
    poses = source(server, up=up, origin=(0.5, 0.5))
    poses.connect()
    try:
        wait_until(lambda: 0 in poses.poses())
        assert set(poses.poses()) == {0}
        pose = poses.poses()[0]
        assert (pose.x, pose.y) == pytest.approx((1.0, 2.0), abs=1e-6)
        assert pose.heading == pytest.approx(math.pi / 2, abs=1e-6)
    finally:
        poses.close()


def test_a_body_that_is_lost_grows_old(server: NatNetServer) -> None:
    """Motive sends a lost body on where it was last; that is no sight of it."""
    upright = (0.0, 0.0, 0.0, 1.0)
    server.bodies = dict.fromkeys((11, 12), ((1.0, 0.0, 1.0), upright, True))
    poses = source(server)
    poses.connect()
    try:
        wait_until(lambda: len(poses.poses()) == 2)
        server.bodies = server.bodies | {11: ((1.0, 0.0, 1.0), upright, False)}
        time.sleep(0.3)
        now = time.monotonic()
        assert now - poses.poses()[0].seen_at > 0.2
        assert now - poses.poses()[1].seen_at < 0.2
    finally:
        poses.close()


def test_no_motive_is_told() -> None:
    """Where nothing answers, the message says what to look at."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        port = silent.getsockname()[1]
        poses = NatNetPoses("127.0.0.1", "127.0.0.1", {11: 0}, ports=(port, port))
        with pytest.raises(StudyError, match="no motion capture at"):
            poses.connect()
