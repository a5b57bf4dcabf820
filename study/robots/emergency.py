"""The emergency stop: a line of its own to every robot, beside whatever drives them."""

from __future__ import annotations

import secrets
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from study.robots.client import RobotAddress
from study.robots.keys import KeyPair, load_zmq, read_pair
from study.robots.link import EmergencyStop, LinkError, Release, RobotState, Status, decode, encode
from study.robots.robots_file import read_robots_file
from study.robots.transport import ZmqTransport

_TIMES = 3
_MOST_ANSWERS = 1000


class EmergencyButton:
    """Stops all robots of a file, whoever drives them; for the thread that made it alone.

    Its lines are open from the beginning: a press does not wait for a handshake.

    Args:
        robots: where they are.
        keys: the operator's.

    Raises:
        StudyError: pyzmq is missing.
    """

    def __init__(self, robots: Sequence[RobotAddress], keys: KeyPair) -> None:
        zmq = load_zmq()
        self._lines = {
            robot.name: ZmqTransport(zmq, robot.address, robot.public_key, keys) for robot in robots
        }
        self._session = secrets.randbits(63) + 1

    @classmethod
    def of_file(cls, path: Path) -> Self:
        """Open the lines to the robots that a file lists.

        Raises:
            StudyError: the file or a key is missing or wrong.
        """
        given = read_robots_file(path)
        robots = [RobotAddress(part.name, part.address, part.public_key) for part in given.robots]
        return cls(robots, read_pair(path.parent / given.operator_key))

    def press(self) -> None:
        """Stop every robot at once; they stay stopped until released."""
        self._say(EmergencyStop(self._session))

    def release(self) -> None:
        """End the emergency; robots stand until they are driven."""
        self._say(Release(self._session))

    def _say(self, message: EmergencyStop | Release) -> None:
        parts = encode(message)
        for _ in range(_TIMES):
            for line in self._lines.values():
                line.send(parts)

    def without_answer(self, *, stopped: bool, timeout_s: float = 3.0) -> list[str]:
        """Say it again until each robot answers that it is so.

        Args:
            stopped: whether robots are to be stopped, or released.
            timeout_s: when to give up.

        Returns:
            Names of the robots that did not answer.
        """
        missing = set(self._lines)
        deadline = time.monotonic() + timeout_s
        while missing and time.monotonic() < deadline:
            if stopped:
                self.press()
            else:
                self.release()
            time.sleep(0.05)
            for name in sorted(missing):
                if _says(self._lines[name], stopped=stopped):
                    missing.discard(name)
        return sorted(missing)

    def close(self) -> None:
        """End the lines. Robots stay as they are. Calling it twice is harmless."""
        for line in self._lines.values():
            line.close()
        self._lines.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _says(line: ZmqTransport, *, stopped: bool) -> bool:
    """Whether a robot's newest answer is that it is stopped, or is not."""
    newest = None
    for _ in range(_MOST_ANSWERS):
        parts = line.receive()
        if parts is None:
            break
        try:
            message = decode(parts)
        except LinkError:
            continue
        if isinstance(message, Status):
            newest = message
    return newest is not None and (newest.state == RobotState.EMERGENCY) == stopped
