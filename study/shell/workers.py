"""A process that serves one object: requests in, answers out, one at a time.

Processes are spawned, never forked: a forked sibling would keep the recording's pipe open.
"""

from __future__ import annotations

import gc
import multiprocessing
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from study.errors import StudyError
from study.shell.interrupts import ctrl_c_later

Serve = Callable[[Any], Any]


def _serve(
    connection: Connection, make: Callable[..., Serve], arguments: tuple[Any, ...], *, tells: bool
) -> None:
    # The study decides when to stop; Ctrl-C reaches the whole terminal group.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What is loaded stays: no garbage collection need walk it, now or later.
    gc.disable()
    serve = _made(make, (*arguments, connection.send) if tells else arguments)
    gc.freeze()
    gc.enable()
    while True:
        try:
            request = connection.recv()
        except (EOFError, OSError):
            return
        try:
            answer: Any = serve(request)
        except Exception as error:
            answer = WorkerFailure(str(error) or type(error).__name__)
        try:
            connection.send(answer)
        except (BrokenPipeError, OSError):
            return


def _made(make: Callable[..., Serve], arguments: tuple[Any, ...]) -> Serve:
    """Make the serving function; if that fails, one that answers each request with the reason."""
    try:
        return make(*arguments)
    except Exception as error:
        failure = WorkerFailure(str(error) or type(error).__name__)
        return lambda _: failure


class WorkerFailure:
    """What a request that raised is answered with."""

    def __init__(self, reason: str) -> None:
        self.reason = reason


class Worker:
    """A spawned process and the pipe to it.

    The connection pickles between our own two processes only; nothing read from a file
    ever goes this way as a pickle.

    Args:
        make: importable function that, in the process, makes the serving function.
        arguments: its arguments.
        tells: whether it gets, last, a function that sends something in the midst of a request.
    """

    def __init__(self, make: Callable[..., Serve], *arguments: object, tells: bool = False) -> None:
        # A child is told its parent's default, and joblib's default is no name it knows.
        if multiprocessing.get_start_method(allow_none=True) not in (None, "spawn"):
            multiprocessing.set_start_method("spawn", force=True)
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve,
            args=(theirs, make, arguments),
            kwargs={"tells": tells},
            daemon=True,
            name=make.__name__,
        )
        with ctrl_c_later():
            self._process.start()
        theirs.close()

    def send(self, request: object) -> None:
        """Ask. Raises StudyError if the process is gone."""
        try:
            self._connection.send(request)
        except (BrokenPipeError, OSError) as error:
            raise StudyError(f"the {self._process.name} process has ended unexpectedly") from error

    def poll(self, seconds: float = 0.0) -> Any | None:  # noqa: ANN401 - what the served object says
        """Return an answer if one comes within ``seconds``, else None.

        Raises:
            StudyError: the process is gone.
        """
        try:
            return self._connection.recv() if self._connection.poll(seconds) else None
        except (EOFError, OSError) as error:
            raise StudyError(f"the {self._process.name} process has ended unexpectedly") from error

    def close(self) -> None:
        """End the process: politely, then not."""
        self._connection.close()
        self._process.join(0.5)
        if self._process.is_alive():
            self._process.kill()
            self._process.join(5.0)
