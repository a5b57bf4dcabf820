"""Finding the sessions that run on this computer."""

from __future__ import annotations

import contextlib
import dataclasses
import socket
import time
from pathlib import Path

from study.console.places import SUFFIX, sockets
from study.console.wire import LONGEST_STATUS, Status, parse_said
from study.errors import StudyError

PATIENCE_S = 1.0
"""How long a session may take to say its state before it is listed as silent."""


@dataclasses.dataclass(frozen=True, slots=True)
class Found:
    """A session that runs.

    Attributes:
        path: of its socket.
        status: what it said; None if it said nothing in time.
    """

    path: Path
    status: Status | None

    @property
    def name(self) -> str:
        """Participant and study, or what is known of a silent one."""
        if self.status is None:
            return f"session {self.path.name.removesuffix(SUFFIX)}, which does not answer"
        return f"{self.status.facts.participant}, {self.status.facts.study}"


def find_sessions() -> list[Found]:
    """Return the sessions that run, newest first; sockets left by ones that were killed go."""
    found = []
    for path in sockets():
        with contextlib.suppress(OSError):
            try:
                found.append(Found(path, _ask(path)))
            except ConnectionRefusedError:
                path.unlink()
            except BlockingIOError:
                # It is there, but too many wait for its answer.
                found.append(Found(path, None))
    return found


def _ask(path: Path) -> Status | None:
    """Return what a session says first; None if nothing comes that is a state.

    Raises:
        OSError: it cannot be reached.
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        connection.settimeout(PATIENCE_S)
        connection.connect(str(path))
        said, until = b"", time.monotonic() + PATIENCE_S
        while b"\n" not in said:
            if len(said) > LONGEST_STATUS or time.monotonic() > until:
                return None
            try:
                data = connection.recv(1 << 16)
            except TimeoutError:
                return None
            if not data:
                return None
            said += data
    with contextlib.suppress(StudyError):
        first = parse_said(said.partition(b"\n")[0])
        return first if isinstance(first, Status) else None
    return None
