"""Passes frames into a pipe without waiting for its reader."""

from __future__ import annotations

import contextlib
import os
import select
import threading
from collections import deque

_CAN_SELECT = os.name == "posix"


class PipeSender:
    """Pushes what the pipe takes at once; a thread sends the rest in order.

    All methods but `join` are called with the lock of ``changed`` held.

    Args:
        pipe: file descriptor of the pipe's writing end.
        changed: notified when there is something to send, and when it closes.
        batch_bytes: bytes that may gather before they are sent together; 0 sends at once.
    """

    def __init__(self, pipe: int, changed: threading.Condition, batch_bytes: int) -> None:
        self._pipe = pipe
        self._changed = changed
        self._batch_bytes = batch_bytes
        self._gathered = 0
        self._outgoing: deque[memoryview] = deque()
        self._closing = False
        if _CAN_SELECT:
            os.set_blocking(pipe, False)
        self._thread = threading.Thread(target=self._send_rest, daemon=True, name="recorder-send")
        self._thread.start()

    def send(self, framed: bytes, *, at_once: bool) -> None:
        """Take a frame; push unless it may wait for others.

        Args:
            framed: the frame.
            at_once: whether neither it nor what gathered before it may wait.
        """
        self._outgoing.append(memoryview(framed))
        self._gathered += len(framed)
        if not at_once and self._gathered <= self._batch_bytes:
            return
        self._gathered = 0
        if _CAN_SELECT:
            if self._batch_bytes:
                self._outgoing = deque([memoryview(b"".join(self._outgoing))])
            self._push()
        if self._outgoing:
            self._changed.notify_all()

    def clear(self) -> None:
        """Forget what was not sent: there is nobody to read it."""
        self._outgoing.clear()

    def close(self) -> None:
        """Let the thread end when all is sent."""
        self._closing = True
        self._changed.notify_all()

    def join(self, timeout: float | None = None) -> bool:
        """Wait for the thread, without the lock; return whether it has ended."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _push(self) -> None:
        """Write to the pipe until it is full."""
        try:
            while self._outgoing:
                rest = self._outgoing[0]
                written = os.write(self._pipe, rest)
                if written < len(rest):
                    self._outgoing[0] = rest[written:]
                else:
                    self._outgoing.popleft()
        except BlockingIOError:
            return
        except OSError:
            # Who listens to the reader learns why: it says so, or ends.
            self._outgoing.clear()

    def _send_rest(self) -> None:
        """Send what the pipe had no room for, until it is closed and all is sent."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._outgoing or self._closing)
                if not self._outgoing:
                    return
                first = self._outgoing[0]
            if _CAN_SELECT:
                select.select([], [self._pipe], [], 0.1)
                with self._changed:
                    self._push()
                continue
            # Pipes elsewhere cannot be asked: this thread, the only one that writes, waits.
            with contextlib.suppress(OSError):
                os.write(self._pipe, first)
            with self._changed:
                if self._outgoing:
                    self._outgoing.popleft()
