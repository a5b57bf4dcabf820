"""Ctrl-C at moments when it would be lost, or be told as a traceback."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker


@contextmanager
def ctrl_c_later() -> Iterator[None]:
    """Hold Ctrl-C back until the end; a process started meanwhile is never reached by it.

    It reaches the whole terminal group, and a process that still imports would tell a traceback.
    """
    if sys.platform == "win32":
        yield
        return
    # Were it started on the way, it would let Ctrl-C through again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
