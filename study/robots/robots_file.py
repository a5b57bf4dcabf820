"""The file that says which robots a study drives: where they are, and who sees them.

    operator_key = "keys/operator.toml"

    [[robots]]
    name = "robot1"
    address = "tcp://192.168.1.21:5555"
    public_key = "..."

    [poses]
    kind = "natnet"
    server = "192.168.1.10"
    local = "192.168.1.11"
    rigid_bodies = [11]

The order of robots is that of their numbers; ``rigid_bodies`` has one streaming id a robot.
A twin writes its own file, with poses of the kind "twin".
"""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from study.errors import ProtocolError, StudyError
from study.robots.client import RobotAddress, RobotClient
from study.robots.fleet import RobotFleet
from study.robots.keys import KEY_PATTERN, PUBLIC_FILE, read_pair
from study.robots.poses import NatNetPoses, PoseSource, TwinPoses
from study.rules import Part, right
from study.toml_text import decoded, parse_toml
from study.validation import checked

MAX_BYTES = 64_000


def _address(given: str) -> str:
    if not re.fullmatch(r"tcp://[A-Za-z0-9.\-]+:\d{1,5}", given):
        raise ValueError(f'"{given[:60]}" given; allowed: tcp://HOST:PORT')
    return given


def _public_key(given: str) -> str:
    if not KEY_PATTERN.fullmatch(given):
        raise ValueError(f"no key; 40 characters are expected, as in {PUBLIC_FILE}")
    return given


Address = Annotated[str, AfterValidator(_address)]
PublicKey = Annotated[str, AfterValidator(_public_key)]


class RobotPart(Part):
    """One robot."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_]{0,30}$", description="what people call it")
    address: Address = Field(description="of its agent")
    public_key: PublicKey = Field(description="its own")


class TwinPosesPart(Part):
    """Poses from the digital twin."""

    kind: Literal["twin"]
    address: Address = Field(description="of the twin's motion capture")
    public_key: PublicKey = Field(description="its own")


class NatNetPosesPart(Part):
    """Poses from OptiTrack's Motive."""

    kind: Literal["natnet"]
    server: str = Field(description="IP address of the computer that runs Motive")
    local: str = Field(description="IP address of this computer on the same network")
    rigid_bodies: tuple[int, ...] = Field(description="streaming ids in the robots' order")
    up: Literal["y", "z"] = Field("y", description="Motive's up axis")
    origin: tuple[float, float] = Field((0.0, 0.0), description="the arena's lower left corner, m")
    multicast: bool = Field(default=False, description="as set in Motive")


class RobotsFile(Part):
    """All of it."""

    operator_key: Path = Field(description="private file, from the folder of this one")
    robots: tuple[RobotPart, ...] = Field(min_length=1, max_length=12)
    poses: TwinPosesPart | NatNetPosesPart = Field(discriminator="kind")

    def _body_each(self) -> Iterator[str]:
        poses = self.poses
        if isinstance(poses, NatNetPosesPart) and len(poses.rigid_bodies) != len(self.robots):
            yield "poses.rigid_bodies must have one id for each robot"

    def _apart(self) -> Iterator[str]:
        for what in ("name", "address", "public_key"):
            values = [getattr(robot, what) for robot in right(self.robots, what)]
            for twice in sorted({value for value in values if values.count(value) > 1}):
                yield f"robots: {what} {twice} is that of two robots"

    rules = (_body_each, _apart)


def read_robots_file(path: Path) -> RobotsFile:
    """Read and check the file.

    Raises:
        StudyError: it cannot be read or is wrong; the message says where.
    """
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise StudyError(
            f"{path}: cannot be read: {error.strerror}",
            "It lists the robots; study robot-twin --write makes one for simulated robots.",
        ) from error
    if len(raw) > MAX_BYTES:
        raise StudyError(f"{path}: more than {MAX_BYTES} bytes")
    given = parse_toml(decoded(raw, str(path)), str(path))
    found = checked(RobotsFile, given)
    if found.made is None:
        raise ProtocolError(str(path), found.problems)
    return found.made


def open_fleet(path: Path) -> RobotFleet:
    """Return the robots that a file lists, not yet connected.

    Raises:
        StudyError: the file, a key or a library is missing or wrong.
    """
    given = read_robots_file(path)
    keys = read_pair(path.parent / given.operator_key)
    clients = [
        RobotClient(RobotAddress(robot.name, robot.address, robot.public_key), keys)
        for robot in given.robots
    ]
    poses: PoseSource
    if isinstance(given.poses, TwinPosesPart):
        poses = TwinPoses(given.poses.address, given.poses.public_key, keys)
    else:
        part = given.poses
        poses = NatNetPoses(
            part.server,
            part.local,
            {body: robot for robot, body in enumerate(part.rigid_bodies)},
            up=part.up,
            origin=part.origin,
            multicast=part.multicast,
        )
    return RobotFleet(clients, poses)


_borrowed: dict[Path, tuple[RobotFleet, int]] = {}
_lock = threading.Lock()


def borrow_fleet(path: Path) -> RobotFleet:
    """Return the connected robots of a file; who asks again in this process gets the same ones.

    A robot obeys one operator, and a study's fleets of two and of three share robots.

    Raises:
        StudyError: they cannot be connected, or not all is live.
    """
    with _lock:
        fleet, users = _borrowed.get(path) or (open_fleet(path), 0)
        if not users:
            fleet.connect()
        _borrowed[path] = fleet, users + 1
        return fleet


def give_back_fleet(path: Path) -> None:
    """Let go of what `borrow_fleet` returned; the last one disconnects the robots."""
    with _lock:
        fleet, users = _borrowed[path]
        if users > 1:
            _borrowed[path] = fleet, users - 1
        else:
            del _borrowed[path]
            fleet.disconnect()
