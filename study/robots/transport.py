"""An encrypted ZeroMQ connection to one robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from study.robots.keys import KeyPair
from study.robots.link import MAX_PIXELS

_MOST_BYTES = 3 * MAX_PIXELS + 256
_QUEUE = 8
"""Messages kept either way; a robot that is out of reach does not get old commands later."""


class ZmqTransport:
    """For the thread that made it alone.

    Args:
        zmq: the module.
        address: of the robot.
        public_key: the robot's own.
        keys: the operator's.
    """

    def __init__(self, zmq: Any, address: str, public_key: str, keys: KeyPair) -> None:  # noqa: ANN401
        self._zmq = zmq
        self._context = zmq.Context()
        self._socket: Any = self._context.socket(zmq.DEALER)
        for option, value in [
            ("LINGER", 100),
            ("MAXMSGSIZE", _MOST_BYTES),
            ("SNDHWM", _QUEUE),
            ("RCVHWM", _QUEUE),
            ("RECONNECT_IVL", 50),
            ("RECONNECT_IVL_MAX", 400),
            # Commands made while nobody is there are not kept for later.
            ("IMMEDIATE", 1),
            ("HANDSHAKE_IVL", 2000),
        ]:
            self._socket.setsockopt(getattr(zmq, option), value)
        self._socket.curve_publickey = keys.public.encode()
        self._socket.curve_secretkey = keys.secret.encode()
        self._socket.curve_serverkey = public_key.encode()
        self._monitor: Any = self._socket.get_monitor_socket(
            zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
        )
        self._socket.connect(address)

    def send(self, parts: Sequence[bytes]) -> None:
        """Send without waiting; what cannot be sent is lost."""
        try:
            self._socket.send_multipart(parts, self._zmq.NOBLOCK)
        except self._zmq.Again:
            return

    def receive(self) -> list[bytes] | None:
        """Return what has come, or None; without waiting."""
        try:
            parts: list[bytes] = self._socket.recv_multipart(self._zmq.NOBLOCK)
        except self._zmq.Again:
            return None
        return parts

    def refused(self) -> bool:
        """Say whether a handshake has failed: a wrong key, on one side or the other."""
        try:
            self._monitor.recv_multipart(self._zmq.NOBLOCK)
        except self._zmq.Again:
            return False
        return True

    def close(self) -> None:
        """End the connection."""
        self._socket.disable_monitor()
        self._monitor.close()
        self._socket.close()
        self._context.term()
