"""The operator's end of the link to one robot, in LeRobot's words.

``connect``, ``get_observation``, ``send_action``, ``disconnect``. A thread of its own repeats the
last action, so that a robot knows its operator alive between two timesteps. When the program
gives no action for `HOLD_S`, the robot is told to stand.
"""

from __future__ import annotations

import dataclasses
import secrets
import threading
import time

from study.errors import StudyError
from study.robots.keys import KeyPair, load_zmq
from study.robots.link import (
    COMMAND_PERIOD_S,
    MAX_ANGULAR,
    MAX_LINEAR,
    Busy,
    Command,
    EmergencyStop,
    Frame,
    Goodbye,
    Hello,
    LinkError,
    Message,
    Release,
    Status,
    Transport,
    Welcome,
    Wrap,
    decode,
    encode,
)
from study.robots.transport import ZmqTransport
from study.robots.watchdog import Limits

HOLD_S = 0.2
"""For how long an action is repeated, seconds."""

_HELLO_PERIOD_S = 0.1
_LOST_S = 0.3
"""Without a status for this long it greets anew: the robot may have been started again."""

_POLL_S = 0.005
"""Between two looks at what the robot says; actions do not wait for it."""

_MOST_MESSAGES = 64


@dataclasses.dataclass(frozen=True, slots=True)
class RobotAddress:
    """Where a robot is and who it is.

    Attributes:
        name: what people call it.
        address: as "tcp://192.168.1.21:5555".
        public_key: its own; an impostor is not talked to.
    """

    name: str
    address: str
    public_key: str


@dataclasses.dataclass(frozen=True, slots=True)
class Action:
    """A velocity: m/s forwards, rad/s counterclockwise."""

    linear: float = 0.0
    angular: float = 0.0


@dataclasses.dataclass(frozen=True, slots=True)
class Observation:
    """The newest that is known of a robot. Ages are in seconds, infinite for what never came.

    Attributes:
        status: None before the first.
        status_age: since it came.
        frame: None before the first.
        frame_age: since a picture came that was new.
        round_trip: from a command to the status that answers it, without the robot's own time;
            seconds.
    """

    status: Status | None
    status_age: float
    frame: Frame | None
    frame_age: float
    round_trip: float


class RobotClient:
    """One robot, simulated or real.

    Args:
        robot: whom to talk to.
        keys: the operator's.
        wrap: makes the transport worse, for rehearsals and tests.
    """

    def __init__(
        self, robot: RobotAddress, keys: KeyPair, wrap: Wrap = lambda transport: transport
    ) -> None:
        self.robot = robot
        self._keys = keys
        self._wrap = wrap
        self._zmq = load_zmq()
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._thread: threading.Thread | None = None
        self._stopping = False
        self._limits = Limits(0.0, 0.0)
        self._welcomed = threading.Event()
        self._refused = ""
        self._session = 0
        self._sequence = 0
        self._action, self._until = Action(), 0.0
        self._halted = False
        self._urgent: list[Message] = []
        self._status: Status | None = None
        self._status_at = self._frame_at = -float("inf")
        self._frame: Frame | None = None
        self._status_order = self._frame_order = 0
        self._round_trip = float("inf")

    @property
    def is_connected(self) -> bool:
        """Whether the robot has said that it obeys."""
        return self._thread is not None and self._welcomed.is_set()

    def connect(self, timeout_s: float = 3.0) -> None:
        """Get hold of the robot.

        Raises:
            StudyError: it refused the key, obeys somebody else, or did not answer.
        """
        if self._thread is not None:
            raise StudyError(f"{self.robot.name} is connected already")
        self._session = secrets.randbits(63) + 1
        self._stopping, self._refused = False, ""
        self._welcomed.clear()
        started = threading.Event()
        self._thread = threading.Thread(
            target=self._serve, args=(started,), name=f"link to {self.robot.name}", daemon=True
        )
        self._thread.start()
        started.wait()
        deadline = time.monotonic() + timeout_s
        while not self._welcomed.wait(0.02):
            if self._refused == "key" or time.monotonic() > deadline:
                refused = self._refused
                self.disconnect()
                raise self._not_connected(refused)

    def _not_connected(self, refused: str) -> StudyError:
        name, address = self.robot.name, self.robot.address
        if refused == "key":
            return StudyError(
                f"{name} at {address} refused the key",
                "Give it this operator's public key, or use the key file it was set up with; "
                "check that the robot's own public key is the one given here.",
            )
        if refused == "busy":
            return StudyError(
                f"{name} at {address} obeys another operator", "End the other program first."
            )
        return StudyError(
            f"{name} did not answer at {address}",
            "Check that it is switched on, its agent runs, and the address and port are right.",
        )

    def get_observation(self) -> Observation:
        """Return the newest that is known, at once."""
        with self._lock:
            now = time.monotonic()
            return Observation(
                status=self._status,
                status_age=now - self._status_at,
                frame=self._frame,
                frame_age=now - self._frame_at,
                round_trip=self._round_trip,
            )

    def send_action(self, action: Action) -> Action:
        """Drive, from now on for at most `HOLD_S`; call it at each timestep.

        Returns:
            What is sent: within the limits, and standing while halted.
        """
        with self._lock:
            linear, angular = self._limits.clip(action.linear, action.angular)
            self._action = Action() if self._halted else Action(linear, angular)
            self._until = time.monotonic() + HOLD_S
            sent = self._action
        self._wake.set()
        return sent

    def halt(self) -> None:
        """Make the robot stand, whatever actions say, until `resume`."""
        with self._lock:
            self._halted, self._action = True, Action()
        self._wake.set()

    def resume(self) -> None:
        """Let actions drive the robot again."""
        with self._lock:
            self._halted = False

    def emergency_stop(self) -> None:
        """Stop the robot at once; it stays stopped until `release`, whoever drives."""
        with self._lock:
            # More than one: a message may be lost.
            self._action = Action()
            self._urgent += [EmergencyStop(self._session)] * 3
        self._wake.set()

    def release(self) -> None:
        """End an emergency."""
        with self._lock:
            self._urgent.append(Release(self._session))
        self._wake.set()

    def disconnect(self) -> None:
        """Stop the robot and let it go. Calling it twice is harmless."""
        thread, self._thread = self._thread, None
        if thread is not None:
            self._stopping = True
            self._wake.set()
            thread.join()
            self._welcomed.clear()

    def _serve(self, started: threading.Event) -> None:
        """Talk to the robot until told to stop: the only one who touches the socket."""
        socket = ZmqTransport(self._zmq, self.robot.address, self.robot.public_key, self._keys)
        transport = self._wrap(socket)
        started.set()
        next_command = next_hello = 0.0
        try:
            while not self._stopping:
                now = time.monotonic()
                woken = self._wake.is_set()
                self._wake.clear()
                if now >= next_hello and not self._heard_lately(now):
                    self._send(transport, Hello(self._session))
                    next_hello = now + _HELLO_PERIOD_S
                with self._lock:
                    urgent, self._urgent = self._urgent, []
                for message in urgent:
                    self._send(transport, message)
                if woken or now >= next_command:
                    self._send(transport, self._command(now))
                    next_command = now + COMMAND_PERIOD_S
                self._take(transport)
                if socket.refused():
                    self._refused = "key"
                # Messages from the robot may wait a little; an action must not.
                self._wake.wait(_POLL_S)
            for message in (self._command(float("inf")), Goodbye(self._session)):
                self._send(transport, message)
        finally:
            socket.close()

    def _heard_lately(self, now: float) -> bool:
        return self._welcomed.is_set() and now - self._status_at < _LOST_S

    def _command(self, now: float) -> Command:
        with self._lock:
            action = self._action if now < self._until else Action()
        self._sequence += 1
        return Command(
            self._session, self._sequence, time.monotonic_ns(), action.linear, action.angular
        )

    def _send(self, transport: Transport, message: Message) -> None:
        transport.send(encode(message))

    def _take(self, transport: Transport) -> None:
        """Take in what the robot has said."""
        for _ in range(_MOST_MESSAGES):
            parts = transport.receive()
            if parts is None:
                return
            try:
                self._hear(decode(parts))
            except LinkError:
                continue

    def _hear(self, message: Message) -> None:
        now, now_ns = time.monotonic(), time.monotonic_ns()
        if isinstance(message, Busy):
            self._refused = "busy"
        elif isinstance(message, Welcome) and message.session == self._session:
            with self._lock:
                self._limits = Limits(
                    min(message.max_linear, MAX_LINEAR), min(message.max_angular, MAX_ANGULAR)
                )
                # Its agent may have been started again, and counts from 1.
                self._status_order = self._frame_order = 0
            self._welcomed.set()
        elif isinstance(message, Status):
            self._hear_status(message, now, now_ns)
        elif isinstance(message, Frame):
            with self._lock:
                self._hear_frame(message, now)

    def _hear_frame(self, frame: Frame, now: float) -> None:
        if frame.sequence <= self._frame_order:
            return
        # A camera that has died inside goes on to deliver its last picture. No sensor sees the
        # same twice, so a picture like the last is none.
        if self._frame is None or frame.pixels != self._frame.pixels:
            self._frame_at = now
        self._frame, self._frame_order = frame, frame.sequence

    def _hear_status(self, status: Status, now: float, now_ns: int) -> None:
        if status.session != self._session:
            # Started again, or taken over: it is ours no more until it welcomes us.
            return
        with self._lock:
            if status.sequence <= self._status_order:
                return
            self._status_order = status.sequence
            self._status, self._status_at = status, now
            if status.command:
                took = now_ns - status.command_sent_ns - status.command_age_ns
                self._round_trip = took / 1e9
