"""Where both command lines begin: Ctrl-C is one line, and no traceback, at any moment."""

from __future__ import annotations

import _thread
import contextlib
import importlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

INTERRUPTED = 130
"""Exit status of a command that Ctrl-C stopped."""
STOPPED = "Stopped.\n"
AGAIN_AFTER_S = 0.02
"""Until Ctrl-C that was lost is tried again."""


def start(module: str) -> None:
    """Import the module of a command line, which takes a while, and run its ``main``.

    Until that has begun `stopped_in_a_line` Ctrl-C ends the process at once.
    """
    sys.unraisablehook = _interrupt_again
    # Whoever started this process may have it ignore Ctrl-C.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _stop_at_once)
    importlib.import_module(module).main()


@contextmanager
def stopped_in_a_line() -> Iterator[None]:
    """Say of what Ctrl-C stops that it stopped, and exit with its status."""
    try:
        if signal.getsignal(signal.SIGINT) is _stop_at_once:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        yield
    except KeyboardInterrupt:
        sys.stderr.write(STOPPED)
        sys.exit(INTERRUPTED)
    except SystemExit as left:
        # Typer makes this of Ctrl-C, and says nothing.
        if left.code == INTERRUPTED:
            sys.stderr.write(STOPPED)
        raise


def _stop_at_once(_number: int, _frame: FrameType | None) -> None:
    """End the process: nothing has begun yet that were to be put in order.

    As an exception Ctrl-C may be lost: in the middle of an import Python calls back where none
    gets through, writes a traceback, and goes on.
    """
    os.write(2, STOPPED.encode())
    os._exit(INTERRUPTED)


def _interrupt_again(lost: sys.UnraisableHookArgs, /) -> None:
    """Try Ctrl-C again that came where no exception gets through; tell all else as ever."""
    if not issubclass(lost.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    # From here it would be lost as well.
    again = threading.Timer(AGAIN_AFTER_S, _interrupt_main)
    again.daemon = True
    with contextlib.suppress(RuntimeError):
        again.start()


def _interrupt_main() -> None:
    """Send Ctrl-C to the main thread, which may be asleep."""
    if sys.platform == "win32":
        _thread.interrupt_main()
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
