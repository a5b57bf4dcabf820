"""A terminal without a screen: a program runs in it, keys go in, and what it draws is kept."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import struct
import subprocess
import termios
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from patience import PATIENCE_S

ROWS, COLUMNS = 40, 120


class Terminal:
    """A program in a terminal of 120 by 40.

    What it draws is taken in all the time, as a terminal does: a program whose output nobody takes
    stands still, and no longer minds its keys.

    Attributes:
        process: the program.
    """

    def __init__(self, process: subprocess.Popen[bytes], descriptor: int) -> None:
        self.process = process
        self._descriptor = descriptor
        self._drawn = b""
        self._lock = threading.Lock()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._take_in, daemon=True)
        self._thread.start()

    @property
    def drawn(self) -> bytes:
        """All bytes that it drew since they were forgotten, its escape sequences included."""
        with self._lock:
            return self._drawn

    def forget(self) -> None:
        """Forget what was drawn so far."""
        with self._lock:
            self._drawn = b""

    def close(self) -> None:
        """Take nothing in any more."""
        self._closed.set()
        self._thread.join(PATIENCE_S)

    def type(self, keys: str) -> None:
        """Press keys."""
        os.write(self._descriptor, keys.encode())

    def wait_for(self, *words: str) -> None:
        """Wait until all of these were drawn since the last call that waited."""
        self.wait_until(lambda: all(word.encode() in self.drawn for word in words))
        self.forget()

    def wait_until(self, reached: Callable[[], bool]) -> None:
        """Let it draw until something holds."""
        deadline = time.monotonic() + PATIENCE_S
        while not reached():
            assert time.monotonic() < deadline, self.drawn[-3000:].decode(errors="replace")
            time.sleep(0.05)

    def _take_in(self) -> None:
        while not self._closed.is_set():
            if not select.select([self._descriptor], [], [], 0.05)[0]:
                continue
            try:
                taken = os.read(self._descriptor, 1 << 16)
            except OSError:
                return  # The program has ended.
            with self._lock:
                self._drawn += taken


@contextmanager
def in_terminal(*command: str, **environment: str) -> Iterator[Terminal]:
    """Run a program in a terminal; it is killed in the end, if it still runs."""
    ours, its = pty.openpty()
    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
    process = subprocess.Popen(
        command,
        stdin=its,
        stdout=its,
        stderr=its,
        start_new_session=True,
        env={**os.environ, "TERM": "xterm-256color", "COLORTERM": "", **environment},
    )
    os.close(its)
    terminal = Terminal(process, ours)
    try:
        yield terminal
    finally:
        process.kill()
        process.wait(PATIENCE_S)
        terminal.close()
        os.close(ours)
