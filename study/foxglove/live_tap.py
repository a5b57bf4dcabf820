"""Passes a session's records on to a live view, without ever waiting for it.

The live view is a process of its own, see `study.foxglove.live_server`. Records go to it through
a pipe that is never waited for: what finds no room waits in a bounded queue, whose oldest records
are dropped when it is full. Whatever becomes of that process, the session does not notice.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import json
import os
import select
import subprocess
import time
from collections import deque
from typing import Self

from study.errors import StudyError
from study.events.fields import Record
from study.events.shell import PicturesTaken
from study.recording.framing import MESSAGE_HEADER, FrameKind, frame
from study.recording.opening import channel_numbers
from study.recording.spawning import spawn_apart
from study.recording.wire import encode

QUEUE_BYTES = 4 * 2**20
"""Bytes that may wait for the live view; older ones are dropped."""

START_TIMEOUT = 60.0
END_TIMEOUT = 1.0
DEFAULT_PORT = 8765
LOOPBACK = ("127.0.0.1", "localhost", "::1")


class LiveTap:
    """The session's end of the pipe to a live view. Used by one thread.

    Attributes:
        passed: records handed to the live view.
        dropped: records that it was too slow for, or that came after its end.
        ended: whether the live view is gone.
    """

    def __init__(self, process: subprocess.Popen[bytes], *, queue_bytes: int = QUEUE_BYTES) -> None:
        assert process.stdin is not None  # noqa: S101 - a pipe, see `start`
        self._process = process
        self._pipe = process.stdin.fileno()
        os.set_blocking(self._pipe, False)
        self._channels = channel_numbers()
        self._queue: deque[bytes] = deque()
        self._queued = 0
        self._limit = queue_bytes
        # What is left of a frame that the pipe took in part: it must follow before all else.
        self._rest = memoryview(b"")
        self.passed = 0
        self.dropped = 0
        self.ended = False
        self.url = ""

    @classmethod
    def start(cls, host: str, port: int) -> Self:
        """Start a live view and wait until it listens.

        Args:
            host: address to listen at.
            port: TCP port; 0 for any that is free.

        Raises:
            StudyError: it is not installed or not available here, or cannot listen there.
        """
        require_live()
        process = spawn_apart("study.foxglove.live_server", host, str(port))
        answer = _first_line(process, START_TIMEOUT)
        if "port" not in answer:
            process.kill()
            process.wait()
            reason = answer.get("error", f"it did not start within {START_TIMEOUT:g} s")
            raise StudyError(
                f"no live view at {host}, port {port}: {reason}",
                "Choose another --live-port, or leave out --live.",
            )
        tap = cls(process)
        shown = f"[{host}]" if ":" in host else host
        tap.url = f"ws://{shown}:{answer['port']}"
        return tap

    @property
    def pid(self) -> int:
        """Process id of the live view."""
        return self._process.pid

    def offer(self, record: Record, log_time_ns: int, sequence: int) -> None:
        """Pass a record on if there is room; it never waits and never fails.

        Pictures are not passed on: nothing there shows them, and they would crowd out the rest.
        """
        if isinstance(record, PicturesTaken):
            return
        if self.ended:
            self.dropped += 1
            return
        data = encode(record)
        channel = self._channels[record.topic]
        head = MESSAGE_HEADER.pack(channel, sequence, log_time_ns, len(data))
        framed = frame(FrameKind.MESSAGES, head + data)
        self._queue.append(framed)
        self._queued += len(framed)
        self._push()
        while self._queued > self._limit:
            self._queued -= len(self._queue.popleft())
            self.dropped += 1

    def drain(self, timeout_s: float) -> bool:
        """Wait until the live view has taken all that waits; return whether it has."""
        deadline = time.monotonic() + timeout_s
        while not self.ended and (self._queue or self._rest) and time.monotonic() < deadline:
            select.select([], [self._pipe], [], 0.05)
            self._push()
        return not (self._queue or self._rest)

    def close(self) -> None:
        """End the live view: politely, then not; it never takes longer than two seconds."""
        self.drain(END_TIMEOUT / 2)
        self.dropped += len(self._queue)
        self._queue.clear()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        try:
            self._process.wait(END_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _push(self) -> None:
        """Write until the pipe is full."""
        try:
            while self._rest or self._queue:
                if not self._rest:
                    framed = self._queue.popleft()
                    self._queued -= len(framed)
                    self.passed += 1
                    self._rest = memoryview(framed)
                self._rest = self._rest[os.write(self._pipe, self._rest) :]
        except BlockingIOError:
            return
        except OSError:
            self.ended = True
            self.dropped += len(self._queue)
            self._queue.clear()
            self._queued = 0
            self._rest = memoryview(b"")


def require_live() -> None:
    """Check that a live view can run here, without loading it.

    Raises:
        StudyError: it cannot; the message says what to install.
    """
    if os.name != "posix":
        raise StudyError("--live works on Linux and macOS only", "Leave out --live.")
    try:
        importlib.metadata.version("foxglove-sdk")
    except importlib.metadata.PackageNotFoundError:
        raise StudyError(
            "--live needs the package foxglove-sdk, which is not installed",
            "Install it: pip install 'scaled-autonomy[live]'",
        ) from None


def _first_line(process: subprocess.Popen[bytes], timeout_s: float) -> dict[str, str]:
    """Return what the live view says first, as JSON; empty if it says nothing in time."""
    assert process.stdout is not None  # noqa: S101 - a pipe, see `LiveTap.start`
    deadline, said = time.monotonic() + timeout_s, b""
    while not said.endswith(b"\n"):
        left = deadline - time.monotonic()
        if left <= 0 or not select.select([process.stdout], [], [], left)[0]:
            return {}
        data = os.read(process.stdout.fileno(), 4096)
        if not data:
            return {"error": "its process ended at once"}
        said += data
    answer: dict[str, str] = json.loads(said)
    return answer
