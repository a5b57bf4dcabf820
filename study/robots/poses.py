"""Where the robots are: from OptiTrack's NatNet, or from the simulation."""

from __future__ import annotations

import dataclasses
import importlib
import math
import threading
import time
from collections.abc import Mapping
from typing import Any, Literal, Protocol

from study.errors import StudyError
from study.robots.keys import KeyPair, load_zmq
from study.robots.link import LinkError, Poses, decode


@dataclasses.dataclass(frozen=True, slots=True)
class Pose:
    """A robot's place in the arena: metres, radians counterclockwise.

    Attributes:
        seen_at: `time.monotonic` when it came.
    """

    x: float
    y: float
    heading: float
    seen_at: float


class PoseSource(Protocol):
    """Tells the newest pose of each robot."""

    def connect(self) -> None:
        """Begin.

        Raises:
            StudyError: nothing answers.
        """
        ...

    def poses(self) -> dict[int, Pose]:
        """Return the newest pose of each robot that was ever seen, at once."""
        ...

    def close(self) -> None:
        """End. Calling it twice is harmless."""
        ...


class TwinPoses:
    """Poses from the digital twin, encrypted as the robots' links are.

    Args:
        address: of the twin's motion capture.
        public_key: its own.
        keys: the operator's.
    """

    def __init__(self, address: str, public_key: str, keys: KeyPair) -> None:
        self._zmq = load_zmq()
        self._address, self._public_key, self._keys = address, public_key, keys
        self._context: Any = None
        self._socket: Any = None
        self._last = 0
        self._known: dict[int, Pose] = {}

    def connect(self) -> None:
        """Begin to listen; poses come when they come."""
        self._context = self._zmq.Context()
        self._socket = self._context.socket(self._zmq.SUB)
        self._socket.setsockopt(self._zmq.LINGER, 0)
        self._socket.setsockopt(self._zmq.RCVHWM, 100)
        self._socket.setsockopt(self._zmq.MAXMSGSIZE, 4096)
        self._socket.setsockopt(self._zmq.RECONNECT_IVL, 50)
        self._socket.curve_publickey = self._keys.public.encode()
        self._socket.curve_secretkey = self._keys.secret.encode()
        self._socket.curve_serverkey = self._public_key.encode()
        self._socket.subscribe(b"")
        self._socket.connect(self._address)

    def poses(self) -> dict[int, Pose]:
        """Return the newest pose of each robot that was ever seen."""
        for _ in range(200):
            try:
                parts = self._socket.recv_multipart(self._zmq.NOBLOCK)
            except self._zmq.Again:
                break
            try:
                message = decode(parts)
            except LinkError:
                continue
            # Numbers begin anew with a twin that was started again.
            if isinstance(message, Poses) and not 0 <= self._last - message.sequence < 100:
                self._last = message.sequence
                now = time.monotonic()
                for seen in message.readings:
                    self._known[seen.robot] = Pose(seen.x, seen.y, seen.heading, now)
        return dict(self._known)

    def close(self) -> None:
        """Stop listening."""
        if self._socket is not None:
            self._socket.close()
            self._context.term()
            self._socket = None


class NatNetPoses:
    """Poses from OptiTrack's Motive, by the library ``natnet``.

    NatNet is neither encrypted nor authenticated: keep it on a network of the laboratory's own.

    Args:
        server: IP address of the computer that runs Motive.
        local: IP address of this computer on the same network.
        rigid_bodies: Motive's streaming id to the robot's number.
        up: Motive's up axis. With "y", Motive's usual one, our y is Motive's -z.
        origin: where the arena's lower left corner is on our axes in Motive's frame, metres.
        multicast: as set in Motive.
        ports: Motive's command and data port.
    """

    def __init__(
        self,
        server: str,
        local: str,
        rigid_bodies: Mapping[int, int],
        *,
        up: Literal["y", "z"] = "y",
        origin: tuple[float, float] = (0.0, 0.0),
        multicast: bool = False,
        ports: tuple[int, int] = (1510, 1511),
    ) -> None:
        try:
            natnet: Any = importlib.import_module("natnet")
        except ImportError as error:
            raise StudyError(
                "motion capture by NatNet needs natnet, which is not installed",
                "In a clone `make jetbot`, elsewhere pip install 'scaled-autonomy[jetbot]'.",
            ) from error
        self._client: Any = natnet.NatNetClient(
            server_ip_address=server,
            local_ip_address=local,
            use_multicast=multicast,
            command_port=ports[0],
            data_port=ports[1],
        )
        self._server = server
        self._robots = dict(rigid_bodies)
        self._up, self._origin = up, origin
        self._lock = threading.Lock()
        self._known: dict[int, Pose] = {}
        self._client.on_data_frame_received_event.handlers.append(self._take)

    def connect(self) -> None:
        """Ask Motive for its stream.

        Raises:
            StudyError: nothing answers.
        """
        try:
            self._client.connect(timeout=3.0)
        except (TimeoutError, OSError, RuntimeError) as error:
            raise StudyError(
                f"no motion capture at {self._server}",
                "Check that Motive streams to this computer's address, and the firewall.",
            ) from error
        self._client.run_async()

    def poses(self) -> dict[int, Pose]:
        """Return the newest pose of each robot that was ever tracked."""
        with self._lock:
            return dict(self._known)

    def close(self) -> None:
        """End the stream."""
        self._client.shutdown()

    def _take(self, frame: Any) -> None:  # noqa: ANN401 - the library's
        now = time.monotonic()
        seen = {}
        for body in frame.rigid_bodies:
            robot = self._robots.get(body.id_num)
            # A body that Motive lost is sent on with its last pose, marked.
            if robot is None or body.tracking_valid is False:
                continue
            pose = _on_the_floor(body.pos, body.rot, self._up)
            if all(map(math.isfinite, pose)):
                x, y, heading = pose
                seen[robot] = Pose(x - self._origin[0], y - self._origin[1], heading, now)
        with self._lock:
            self._known.update(seen)


def _on_the_floor(
    place: tuple[float, float, float],
    turn: tuple[float, float, float, float],
    up: Literal["y", "z"],
) -> tuple[float, float, float]:
    """Return x, y and heading of a rigid body whose x axis points ahead.

    Args:
        place: x, y, z in Motive's frame, metres.
        turn: quaternion x, y, z, w.
        up: the axis that points up.
    """
    x, y, z, w = turn
    ahead_x = 1 - 2 * (y * y + z * z)
    if up == "z":
        return place[0], place[1], math.atan2(2 * (x * y + w * z), ahead_x)
    return place[0], -place[2], math.atan2(-2 * (x * z - w * y), ahead_x)
