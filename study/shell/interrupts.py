"""Ctrl-C at moments when it would be lost, or be told as a traceback."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from types import FrameType


@contextmanager
def ctrl_c_later() -> Iterator[None]:
    """Hold Ctrl-C back until the end; a process started meanwhile is never reached by it.

    It reaches the whole terminal group, and a process that still imports would tell a traceback.
    """
    if sys.platform == "win32":
        with _noted():
            yield
        return
    # Were it started on the way, it would let Ctrl-C through again.
    resource_tracker.ensure_running()
    with _noted():
        # A process inherits this, though not the handler.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _noted() -> Iterator[None]:
    """Note Ctrl-C instead of acting on it; act at the end.

    A mask holds for one thread: while others run, numpy's among them, Ctrl-C reaches one of
    those, and Python has the main thread act on it. As an exception amid a call of SDL's that
    discards exceptions, such as the one that looks for an icon, it would be lost.
    """
    handler = signal.getsignal(signal.SIGINT)
    ours = threading.current_thread() is threading.main_thread()
    if not ours or handler in (signal.SIG_IGN, signal.SIG_DFL, None):
        yield
        return
    came = False

    def note(_number: int, _frame: FrameType | None) -> None:
        nonlocal came
        came = True

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if came:
            signal.raise_signal(signal.SIGINT)
