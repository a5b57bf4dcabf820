"""Starts the processes that take records on standard input: the writer, and the live view."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import study

_PIPE_SIZE = 1 << 20


def spawn_writer() -> subprocess.Popen[bytes]:
    """Start a writer that reads frames on its standard input; see `study.recording.writer`.

    It runs apart, see `spawn_apart`, with as much room in its pipe as there can be.
    """
    process = spawn_apart("study.recording.writer")
    if sys.platform == "linux" and process.stdin is not None:
        import fcntl  # noqa: PLC0415 - not on every platform

        # More room lets a study that is killed have handed over more; the default does too.
        with contextlib.suppress(OSError):
            fcntl.fcntl(process.stdin.fileno(), fcntl.F_SETPIPE_SZ, _PIPE_SIZE)
    return process


def spawn_apart(module: str, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a module of this very code, wherever the study was started from, with two pipes.

    It runs in a session of its own, so that Ctrl-C in the terminal does not reach it.
    """
    source = str(Path(study.__file__ or "").parent.parent)
    inherited = os.environ.get("PYTHONPATH")
    search_path = os.pathsep.join([source, inherited]) if inherited else source
    return subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        bufsize=0,
        env={**os.environ, "PYTHONPATH": search_path},
        start_new_session=True,
    )
