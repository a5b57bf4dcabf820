"""The robot link's words: what operator and robot say to each other, as bytes.

Each message is one frame of fixed layout, told by its kind; a camera frame has its pixels in a
second one. Nothing is decoded but numbers and short names, and every size is known before it is
read. The link runs over ZeroMQ, authenticated and encrypted by CURVE: robots answer only those
whose keys they know.

A command carries its sequence number and the operator's clock. A robot obeys a command only if
it is newer than the last, and for `VALID_S` from when it was sent. Clocks need not agree: the
shortest way that any command of a session took counts as no delay.
"""

from __future__ import annotations

import dataclasses
import math
import struct
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Any, ClassVar, Protocol

STOP_BOUND_S = 0.25
"""A robot that hears nothing has stopped its motors after this, seconds."""

VALID_S = 0.18
"""How long a command moves a robot, seconds; below the bound by what a busy machine sleeps."""

COMMAND_PERIOD_S = 0.04
"""Between two commands of an operator's link, seconds; four in a row may be lost."""

MAX_LINEAR, MAX_ANGULAR = 0.5, 4.0
"""Speed limits of the protocol, m/s and rad/s: no message can name more."""

MAX_PIXELS = 640 * 480
MAX_POSES = 64

_MAGIC = b"SAR\x01"


class LinkError(ValueError):
    """Bytes that are no message of the link."""


class RobotState(IntEnum):
    """What a robot's agent does."""

    FREE = 0
    """Nobody is connected."""
    OBEYING = 1
    SILENT = 2
    """Stopped by the watchdog: no valid command."""
    EMERGENCY = 3
    """Stopped until released."""


@dataclasses.dataclass(frozen=True, slots=True)
class Hello:
    """An operator asks for the robot. ``session`` is a random number but 0."""

    LAYOUT: ClassVar[str] = "Q"
    session: int


@dataclasses.dataclass(frozen=True, slots=True)
class Welcome:
    """The robot is the operator's; its limits are those of the protocol or lower."""

    LAYOUT: ClassVar[str] = "Qdd"
    session: int
    max_linear: float
    max_angular: float


@dataclasses.dataclass(frozen=True, slots=True)
class Busy:
    """The robot obeys another operator."""

    LAYOUT: ClassVar[str] = "Q"
    session: int


@dataclasses.dataclass(frozen=True, slots=True)
class Command:
    """Drive: m/s forwards, rad/s counterclockwise. ``sent_ns`` is of the operator's clock."""

    LAYOUT: ClassVar[str] = "QQQdd"
    session: int
    sequence: int
    sent_ns: int
    linear: float
    angular: float


@dataclasses.dataclass(frozen=True, slots=True)
class EmergencyStop:
    """Stop and stay stopped, whoever says so."""

    LAYOUT: ClassVar[str] = "Q"
    session: int


@dataclasses.dataclass(frozen=True, slots=True)
class Release:
    """End an emergency, whoever says so; the robot stands until it is driven."""

    LAYOUT: ClassVar[str] = "Q"
    session: int


@dataclasses.dataclass(frozen=True, slots=True)
class Goodbye:
    """The operator lets the robot go."""

    LAYOUT: ClassVar[str] = "Q"
    session: int


@dataclasses.dataclass(frozen=True, slots=True)
class Status:
    """How the robot is.

    Attributes:
        session: whom it obeys; 0 for nobody.
        sequence: of the statuses, from 1.
        at_ns: the robot's clock.
        command: sequence number of the last command obeyed.
        command_sent_ns: that command's own time.
        command_age_ns: how long before ``at_ns`` it arrived.
        ignored: commands not obeyed in this session: old, late, out of order.
        linear, angular: what the motors are told, m/s and rad/s.
        battery: 0 (flat) to 1 (full).
        state: what the agent does.
    """

    LAYOUT: ClassVar[str] = "QQQQQQQdddB"
    session: int
    sequence: int
    at_ns: int
    command: int
    command_sent_ns: int
    command_age_ns: int
    ignored: int
    linear: float
    angular: float
    battery: float
    state: int


@dataclasses.dataclass(frozen=True, slots=True)
class Frame:
    """A picture of the front camera: rows from the top, each pixel red, green, blue."""

    LAYOUT: ClassVar[str] = "QQHH"
    sequence: int
    at_ns: int
    width: int
    height: int
    pixels: bytes = b""


@dataclasses.dataclass(frozen=True, slots=True)
class PoseReading:
    """One robot's pose: metres, radians counterclockwise."""

    robot: int
    x: float
    y: float
    heading: float


@dataclasses.dataclass(frozen=True, slots=True)
class Poses:
    """What simulated motion capture sees at one moment; robots that it does not see are missing."""

    LAYOUT: ClassVar[str] = "QQH"
    sequence: int
    at_ns: int
    readings: tuple[PoseReading, ...] = ()


Message = (
    Hello | Welcome | Busy | Command | EmergencyStop | Release | Goodbye | Status | Frame | Poses
)

_KINDS: tuple[type[Any], ...] = (
    *(Hello, Welcome, Busy, Command, EmergencyStop, Release, Goodbye),
    *(Status, Frame, Poses),
)
_STRUCTS = tuple(struct.Struct(f"<4sB{kind.LAYOUT}") for kind in _KINDS)
_POSE = struct.Struct("<Hddd")


class Transport(Protocol):
    """Carries messages to one robot and back, some of them, in some order."""

    def send(self, parts: Sequence[bytes]) -> None:
        """Send without waiting; what cannot be sent is lost."""
        ...

    def receive(self) -> list[bytes] | None:
        """Return what has come, or None; without waiting."""
        ...


Wrap = Callable[[Transport], Transport]


def encode(message: Message) -> list[bytes]:
    """Return the frames of a message.

    Raises:
        LinkError: it says something that the protocol cannot.
    """
    kind = _KINDS.index(type(message))
    numbers: list[int | float] = []
    tail: list[bytes] = []
    for field in dataclasses.fields(message):
        value = getattr(message, field.name)
        if isinstance(value, bytes):
            tail.append(value)
        elif isinstance(value, tuple):
            numbers.append(len(value))
            tail.append(b"".join(_POSE.pack(p.robot, p.x, p.y, p.heading) for p in value))
        else:
            numbers.append(value)
    try:
        parts = [_STRUCTS[kind].pack(_MAGIC, kind, *numbers), *tail]
    except struct.error as error:
        raise LinkError(f"{message}: {error}") from error
    decode(parts)
    return parts


def decode(parts: Sequence[bytes]) -> Message:
    """Read a message.

    Args:
        parts: the frames as they came, from anybody.

    Raises:
        LinkError: they are no message, or one that says something impossible.
    """
    if not 1 <= len(parts) <= 2 or len(parts[0]) < 5 or parts[0][:4] != _MAGIC:
        raise LinkError("not a message of this version of the robot link")
    kind = parts[0][4]
    if kind >= len(_KINDS) or len(parts[0]) != _STRUCTS[kind].size:
        raise LinkError("a message of unknown kind or wrong length")
    numbers: list[Any] = list(_STRUCTS[kind].unpack(parts[0])[2:])
    if not all(math.isfinite(number) for number in numbers):
        raise LinkError("a number that is none")
    tail = parts[1] if len(parts) == 2 else None
    if _KINDS[kind] is Poses:
        numbers[-1] = _readings(numbers[-1], tail)
    elif _KINDS[kind] is Frame:
        if numbers[2] * numbers[3] > MAX_PIXELS or not numbers[2] * numbers[3]:
            raise LinkError("a camera frame of impossible size")
        if tail is None or len(tail) != 3 * numbers[2] * numbers[3]:
            raise LinkError("a camera frame that is not as large as it says")
        numbers.append(bytes(tail))
    elif tail is not None:
        raise LinkError("more than a message of its kind holds")
    message: Message = _KINDS[kind](*numbers)
    _check(message)
    return message


def _readings(count: int, tail: bytes | None) -> tuple[PoseReading, ...]:
    if count > MAX_POSES or tail is None or len(tail) != count * _POSE.size:
        raise LinkError("poses that are not as many as they say")
    readings = tuple(PoseReading(*values) for values in _POSE.iter_unpack(tail))
    for reading in readings:
        if not all(map(math.isfinite, (reading.x, reading.y, reading.heading))):
            raise LinkError("a pose that is none")
    return readings


def _check(message: Message) -> None:
    """Refuse what is well formed and cannot be.

    Raises:
        LinkError: it is.
    """
    if isinstance(message, Command | Status) and not (
        abs(message.linear) <= MAX_LINEAR and abs(message.angular) <= MAX_ANGULAR
    ):
        raise LinkError("a speed above the protocol's limit")
    if isinstance(message, Welcome) and not (
        0 < message.max_linear <= MAX_LINEAR and 0 < message.max_angular <= MAX_ANGULAR
    ):
        raise LinkError("a limit above the protocol's")
    if isinstance(message, Status) and not (
        0 <= message.battery <= 1 and message.state in set(RobotState)
    ):
        raise LinkError("a status that cannot be")
    if not isinstance(message, Status | Frame | Poses) and message.session == 0:
        raise LinkError("a session without a number")
