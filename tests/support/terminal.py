"""A terminal without a screen: a program runs in it, keys go in, and what it draws is kept."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import struct
import subprocess
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from patience import PATIENCE_S

ROWS, COLUMNS = 40, 120


class Terminal:
    """A program in a terminal of 120 by 40.

    Attributes:
        process: the program.
        drawn: all bytes that it drew, its escape sequences included.
    """

    def __init__(self, process: subprocess.Popen[bytes], descriptor: int) -> None:
        self.process = process
        self.drawn = b""
        self._descriptor = descriptor

    def type(self, keys: str) -> None:
        """Press keys."""
        os.write(self._descriptor, keys.encode())

    def wait_for(self, *words: str) -> None:
        """Wait until all of these were drawn since the last call that waited."""
        self.wait_until(lambda: all(word.encode() in self.drawn for word in words))
        self.drawn = b""

    def wait_until(self, reached: Callable[[], bool]) -> None:
        """Let it draw until something holds."""
        deadline = time.monotonic() + PATIENCE_S
        while not reached():
            assert time.monotonic() < deadline, self.drawn[-3000:].decode(errors="replace")
            self.draw()

    def draw(self, seconds: float = 0.05) -> None:
        """Take in what it draws within a moment."""
        if select.select([self._descriptor], [], [], seconds)[0]:
            try:
                self.drawn += os.read(self._descriptor, 1 << 16)
            except OSError:
                time.sleep(seconds)  # The program has ended.


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
    try:
        yield Terminal(process, ours)
    finally:
        process.kill()
        process.wait(PATIENCE_S)
        os.close(ours)
