"""The session's end of the link to consoles: a private socket that is never waited for.

Whatever a console does (dies, stops reading, sends rubbish without end) the session notices
nothing but a line that it refuses. A tick takes a bounded number of bytes and lines.
"""

from __future__ import annotations

import contextlib
import os
import select
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Self

from study.console.places import socket_path
from study.console.tracker import Tracker
from study.console.wire import (
    LONGEST_COMMAND,
    Answer,
    Command,
    Disk,
    Ended,
    Status,
    parse_command,
)
from study.errors import StudyError

STATUS_EVERY_NS = 250_000_000
MOST_CONSOLES = 4
MOST_REFUSALS = 20
"""Lines of rubbish after which a console is hung up on."""
_READ = 4096
_LINES_A_TICK = 2
_LONGEST_QUEUE = 1 << 18


class ConsoleLink:
    """Listens for consoles. Used by the session's thread alone.

    Args:
        path: of the socket; there is none of that name.
        tracker: what is told.
        disk: how far the recording has got, asked when it is told.

    Raises:
        OSError: it cannot listen there.
    """

    def __init__(self, path: Path, tracker: Tracker, disk: Callable[[], Disk]) -> None:
        self._path = path
        self._tracker = tracker
        self._disk = disk
        self._consoles: list[_Console] = []
        self._next_ns = 0
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        # Found only once it listens: whoever is refused there takes it for a session that is gone.
        part = path.with_name(f".{path.name}.{os.getpid()}")
        try:
            part.unlink(missing_ok=True)
            self._listener.bind(str(part))
            part.chmod(0o600)
            self._listener.listen(MOST_CONSOLES)
            self._listener.setblocking(False)  # noqa: FBT003
            part.replace(path)
        except OSError:
            self._listener.close()
            raise

    @classmethod
    def open(cls, session_id: str, tracker: Tracker, disk: Callable[[], Disk]) -> Self:
        """Listen where consoles look.

        Raises:
            StudyError: it cannot be had here.
        """
        path = socket_path(session_id)
        try:
            return cls(path, tracker, disk)
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror or error}") from error

    def poll(self) -> list[Command]:
        """Take in what consoles have sent; return the commands to be done, in order."""
        try:
            waiting = [self._listener, *(each.socket for each in self._consoles)]
            readable = set(select.select(waiting, [], [], 0)[0])
        except (OSError, ValueError):
            readable = set()
        if self._listener in readable:
            self._welcome()
        commands: list[Command] = []
        for console in self._consoles:
            if console.socket in readable:
                console.read()
            understood = (self._understood(console, line) for line in console.lines())
            commands += [command for command in understood if command]
        self._consoles = [each for each in self._consoles if each.open]
        return commands

    def tell(self, t_ns: int) -> None:
        """Send the state if it is time; nothing is done while nobody listens.

        Args:
            t_ns: the session's time.
        """
        if not self._consoles or t_ns < self._next_ns:
            return
        self._next_ns = t_ns + STATUS_EVERY_NS
        line = _line(self._tracker.status(t_ns, self._disk()))
        for console in self._consoles:
            console.tell(line)

    def close(self) -> None:
        """Say how the session ended, if it did, and take the socket away."""
        ended = self._tracker.ended
        for console in self._consoles:
            if ended is not None:
                console.tell(_line(self._tracker.status(ended.t_ns, self._disk())))
                console.say(_line(Ended(complete=ended.complete, reason=ended.reason)))
            console.close()
        self._consoles.clear()
        self._listener.close()
        with contextlib.suppress(OSError):
            self._path.unlink()

    def _welcome(self) -> None:
        with contextlib.suppress(OSError):
            for _ in range(MOST_CONSOLES):
                accepted, _ = self._listener.accept()
                if len(self._consoles) >= MOST_CONSOLES:
                    accepted.close()
                    continue
                self._consoles.append(_Console(accepted))
                self._next_ns = 0

    def _understood(self, console: _Console, line: bytes) -> Command | None:
        if not console.open:
            return None
        try:
            command = parse_command(line)
        except StudyError as error:
            console.refusals += 1
            console.say(_line(Answer(refused=str(error))))
            if console.refusals >= MOST_REFUSALS:
                console.close()
            return None
        refused = self._out_of_place(command)
        console.say(_line(Answer(command=command.command, refused=refused)))
        return None if refused else command

    def _out_of_place(self, command: Command) -> str:
        """Return why a command makes no sense now; empty if it does."""
        state = self._tracker.state
        if state == "ended":
            return "the session has ended"
        if command.command == "pause" and state == "held":
            return "the session is paused already"
        if command.command == "resume" and state == "paused":
            return "the participant ends this pause, not the experimenter"
        if command.command == "resume" and state == "running":
            return "the session is not paused"
        return ""


class _Console:
    """One console that listens.

    Attributes:
        socket: non-blocking.
        open: whether it is still there.
        refusals: lines that were no commands.
    """

    def __init__(self, connected: socket.socket) -> None:
        connected.setblocking(False)  # noqa: FBT003
        self.socket = connected
        self.open = True
        self.refusals = 0
        self._come = b""
        self._going = b""

    def read(self) -> None:
        """Take in what fits, unless a line waits to be looked at."""
        if not self.open or b"\n" in self._come:
            return
        try:
            data = self.socket.recv(_READ)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.close()
            return
        self._come += data

    def lines(self) -> list[bytes]:
        """Return the lines to look at in this tick."""
        found: list[bytes] = []
        while self.open and len(found) < _LINES_A_TICK and b"\n" in self._come:
            line, _, self._come = self._come.partition(b"\n")
            if line.strip():
                found.append(line)
        if b"\n" not in self._come and len(self._come) > LONGEST_COMMAND:
            found.append(self._come)
            self._come = b""
            self.refusals = MOST_REFUSALS
        return found

    def tell(self, line: bytes) -> None:
        """Send a state, unless earlier ones have not gone yet: this one is then left out."""
        if self._going:
            self._push()
        if not self._going:
            self.say(line)

    def say(self, line: bytes) -> None:
        """Send a line as far as there is room; the rest goes later."""
        if self.open and len(self._going) + len(line) <= _LONGEST_QUEUE:
            self._going += line
            self._push()

    def close(self) -> None:
        """Hang up."""
        self.open = False
        self.socket.close()

    def _push(self) -> None:
        try:
            while self._going and self.open:
                self._going = self._going[self.socket.send(self._going) :]
        except BlockingIOError:
            return
        except OSError:
            self.close()


def _line(said: Status | Answer | Ended) -> bytes:
    return said.model_dump_json().encode() + b"\n"
