"""The agent on a robot: a watchdog behind an encrypted socket.

It needs Python and pyzmq, no NumPy. The simulated robots of `study.robots.twin` run the same
agent.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

from study.errors import StudyError
from study.robots.keys import KeyPair, load_zmq
from study.robots.link import Frame, LinkError, Message, decode, encode
from study.robots.watchdog import Watchdog

_MOST_MESSAGES = 64
"""Handled before the watchdog is looked at again: a flood cannot keep it asleep."""

_MOST_BYTES = 2048
"""Of a message to a robot, those of the handshake included; longer ones are not even received."""

_STATUS_PERIOD_NS = 50_000_000
_QUEUE = 4
"""Messages kept for an operator who does not take them; the next are dropped."""


class Camera(Protocol):
    """Takes pictures at its own pace."""

    def frame(self) -> Frame | None:
        """Return a picture if there is a new one since the last call; without waiting."""
        ...


class Agent:
    """One robot on the network.

    Args:
        watchdog: what drives the robot.
        camera: its front camera, or None.
        keys: the robot's own.
        operators: public keys of those who may drive.
        address: where to listen, as "tcp://*:5555"; "tcp://127.0.0.1:*" takes a free port.
        clock_ns: monotonic.

    Raises:
        StudyError: pyzmq is missing, or the address cannot be listened at.
    """

    def __init__(
        self,
        watchdog: Watchdog,
        camera: Camera | None,
        *,
        keys: KeyPair,
        operators: frozenset[str],
        address: str,
        clock_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._zmq = load_zmq()
        self._watchdog = watchdog
        self._camera = camera
        self._clock_ns = clock_ns
        self._status_ns = 0
        self._context = self._zmq.Context()
        self._door = Door(self._context, operators)
        self._socket: Any = self._context.socket(self._zmq.ROUTER)
        for option, value in [
            ("LINGER", 0),
            ("MAXMSGSIZE", _MOST_BYTES),
            ("SNDHWM", _QUEUE),
            ("RCVHWM", _MOST_MESSAGES),
        ]:
            self._socket.setsockopt(getattr(self._zmq, option), value)
        self._socket.curve_server = True
        self._socket.curve_publickey = keys.public.encode()
        self._socket.curve_secretkey = keys.secret.encode()
        try:
            self._socket.bind(address)
        except self._zmq.ZMQError as error:
            self.close()
            raise StudyError(f"{address}: cannot listen there: {error}") from error
        self.address: str = self._socket.last_endpoint.decode()

    def step(self, wait_s: float = 0.0) -> None:
        """Act on what has come, look at the watchdog, say how the robot is.

        Args:
            wait_s: for how long to wait for a message.
        """
        if wait_s > 0:
            self._socket.poll(round(1000 * wait_s))
        for _ in range(_MOST_MESSAGES):
            received = self._receive()
            if received is None:
                break
            sender, message = received
            if message is None:
                continue
            answer = self._watchdog.hear(sender, message, self._clock_ns())
            if answer is not None:
                self._send(sender, answer)
        now = self._clock_ns()
        stopped = self._watchdog.tick(now)
        holder = self._watchdog.holder
        if holder and (stopped or now - self._status_ns >= _STATUS_PERIOD_NS):
            self._status_ns = now
            self._send(holder, self._watchdog.status(now))
        if self._camera is not None and (frame := self._camera.frame()) and holder:
            self._send(holder, frame)

    def run(self, goes_on: Callable[[], bool] = lambda: True) -> None:
        """Serve until told otherwise; the robot is stopped when it ends, however it ends."""
        try:
            while goes_on():
                self.step(wait_s=0.01)
        finally:
            self.close()

    def close(self) -> None:
        """Stop the robot and leave the network. Calling it twice is harmless."""
        self._watchdog.tick(1 << 62)
        self._socket.close()
        self._door.close()
        self._context.term()

    def _receive(self) -> tuple[bytes, Message | None] | None:
        """Return sender and message; None for the message if it is none."""
        try:
            sender, *parts = self._socket.recv_multipart(self._zmq.NOBLOCK)
        except self._zmq.Again:
            return None
        try:
            return sender, decode(parts)
        except LinkError:
            return sender, None

    def _send(self, to: bytes, message: Message) -> None:
        try:
            self._socket.send_multipart([to, *encode(message)], self._zmq.NOBLOCK)
        except self._zmq.ZMQError:
            # Gone, or too slow: the next status replaces this one.
            return


class Door:
    """Lets in who proves to hold an operator's key: ZeroMQ asks it at each handshake."""

    def __init__(self, context: Any, operators: frozenset[str]) -> None:  # noqa: ANN401
        from zmq.auth.thread import ThreadAuthenticator  # noqa: PLC0415 - an extra

        self._operators = operators
        self._authenticator = ThreadAuthenticator(context)
        self._authenticator.start()
        self._authenticator.configure_curve_callback(domain="*", credentials_provider=self)

    def callback(self, domain: str, key: bytes) -> bool:  # noqa: ARG002 - pyzmq's signature
        """Return whether a public key is an operator's."""
        return key.decode() in self._operators

    def close(self) -> None:
        """Stop asking. Calling it twice is harmless."""
        if self._authenticator.is_alive():
            self._authenticator.stop()
