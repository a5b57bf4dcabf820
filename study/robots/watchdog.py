"""What a robot's agent does with each message and with silence; it knows no socket and no clock."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Protocol

from study.robots.link import (
    MAX_ANGULAR,
    MAX_LINEAR,
    VALID_S,
    Busy,
    Command,
    EmergencyStop,
    Goodbye,
    Hello,
    Message,
    Release,
    RobotState,
    Status,
    Welcome,
)

_VALID_NS = int(VALID_S * 1e9)
_DRIFT = 2e-4
"""How fast two clocks may part: what counts as no delay is forgotten at this rate."""


class Motors(Protocol):
    """What drives: the robot's own library, or a simulation."""

    def set_velocity(self, linear: float, angular: float) -> None:
        """Drive, m/s forwards and rad/s counterclockwise, until told otherwise."""
        ...


@dataclasses.dataclass(frozen=True, slots=True)
class Limits:
    """Speeds that a robot never exceeds, m/s and rad/s; at most the protocol's."""

    linear: float = MAX_LINEAR
    angular: float = MAX_ANGULAR

    def clip(self, linear: float, angular: float) -> tuple[float, float]:
        """Return a velocity within the limits."""
        return (
            min(max(linear, -self.linear), self.linear),
            min(max(angular, -self.angular), self.angular),
        )


class Watchdog:
    """Obeys one operator at a time, newest valid command first; stops when there is none.

    Args:
        motors: what it drives; it is stopped at once.
        battery: returns 0 (flat) to 1 (full).
        limits: speeds never exceeded.
    """

    def __init__(
        self, motors: Motors, battery: Callable[[], float], limits: Limits = Limits()
    ) -> None:
        self._motors = motors
        self._battery = battery
        self._limits = limits
        self._holder = b""
        self._session = 0
        self._emergency = False
        self._last: Command | None = None
        self._arrived_ns = 0
        self._shortest_ns: int | None = None
        self._shortest_at_ns = 0
        self._until_ns = 0
        self._heard_ns = 0
        self._ignored = 0
        self._statuses = 0
        self._velocity = (0.0, 0.0)
        motors.set_velocity(0.0, 0.0)

    @property
    def holder(self) -> bytes:
        """Whom it obeys, as the transport names senders; empty for nobody."""
        return self._holder

    def hear(self, sender: bytes, message: Message, now_ns: int) -> Message | None:
        """Act on a message.

        Args:
            sender: as the transport names it.
            message: as decoded.
            now_ns: the robot's clock.

        Returns:
            The answer, or None for none.
        """
        if isinstance(message, EmergencyStop):
            self._emergency = True
            self._drive(0.0, 0.0)
            return self.status(now_ns)
        if isinstance(message, Release):
            # A command from before the release does not set off the robot.
            self._emergency, self._until_ns = False, 0
            return self.status(now_ns)
        if isinstance(message, Hello):
            return self._greet(sender, message.session, now_ns)
        if sender != self._holder or getattr(message, "session", 0) != self._session:
            return None
        if isinstance(message, Command):
            return self.status(now_ns) if self._obey(message, now_ns) else None
        if isinstance(message, Goodbye):
            self._let_go()
        return None

    def _greet(self, sender: bytes, session: int, now_ns: int) -> Message:
        held = self._session != 0 and now_ns - self._heard_ns <= _VALID_NS
        if (sender, session) != (self._holder, self._session):
            if held:
                return Busy(session)
            self._let_go()
            self._holder, self._session = sender, session
        self._heard_ns = now_ns
        return Welcome(session, self._limits.linear, self._limits.angular)

    def _obey(self, command: Command, now_ns: int) -> bool:
        """Take a command if it is newer than the last and still valid."""
        if self._last is not None and command.sequence <= self._last.sequence:
            self._ignored += 1
            return False
        took = now_ns - command.sent_ns
        if self._shortest_ns is not None:
            forgotten = int(_DRIFT * (now_ns - self._shortest_at_ns))
            self._shortest_ns = min(took, self._shortest_ns + forgotten)
        else:
            self._shortest_ns = took
        self._shortest_at_ns = now_ns
        until = command.sent_ns + self._shortest_ns + _VALID_NS
        if until <= now_ns:
            self._ignored += 1
            return False
        self._last, self._arrived_ns, self._until_ns = command, now_ns, until
        self._heard_ns = now_ns
        if not self._emergency:
            self._drive(*self._limits.clip(command.linear, command.angular))
        return True

    def tick(self, now_ns: int) -> bool:
        """Stop if the last command is valid no more. To be called every few milliseconds.

        Returns:
            Whether it stopped the robot now.
        """
        if now_ns < self._until_ns or self._velocity == (0.0, 0.0):
            return False
        self._drive(0.0, 0.0)
        return True

    def status(self, now_ns: int) -> Status:
        """Return how the robot is."""
        self._statuses += 1
        last = self._last
        if self._emergency:
            state = RobotState.EMERGENCY
        elif not self._session:
            state = RobotState.FREE
        else:
            state = RobotState.OBEYING if now_ns < self._until_ns else RobotState.SILENT
        return Status(
            session=self._session,
            sequence=self._statuses,
            at_ns=now_ns,
            command=last.sequence if last else 0,
            command_sent_ns=last.sent_ns if last else 0,
            command_age_ns=now_ns - self._arrived_ns if last else 0,
            ignored=self._ignored,
            linear=self._velocity[0],
            angular=self._velocity[1],
            battery=min(max(self._battery(), 0.0), 1.0),
            state=int(state),
        )

    def _let_go(self) -> None:
        """Forget the operator. An emergency stays: the next one releases it."""
        self._drive(0.0, 0.0)
        self._holder, self._session = b"", 0
        self._last, self._shortest_ns, self._ignored = None, None, 0
        self._until_ns = 0

    def _drive(self, linear: float, angular: float) -> None:
        self._velocity = (linear, angular)
        self._motors.set_velocity(linear, angular)
