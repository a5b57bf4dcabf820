"""A program that has imported the study's commands, and runs each in a fork of itself.

Importing takes most of the time of a command that refuses what it is given. What runs is what
``python -m study.commands.main`` runs, in a process of its own, with files for its output.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib
import json
import os
import runpy
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

MODULE = "study.commands.main"
OFTEN_NEEDED = (
    "pandas",
    "study.commands.running",
    "study.tasks.navigation",
    "study.scorers.luce",
    "analysis.planning.pilot",
    "scipy.stats",
    "analysis.commands.main",
)
SELDOM_THE_SAME = {"PYTEST_CURRENT_TEST"}


class WarmProgram:
    """Hands commands to the program; it ends with the process that began it.

    Args:
        environment: the program's, and so each command's.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = _lasting(environment)
        self._program = subprocess.Popen(
            [sys.executable, __file__],
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def serves(self, environment: Mapping[str, str]) -> bool:
        """Return whether a command of that environment may be handed to it."""
        return _lasting(environment) == self._environment and self._program.poll() is None

    def run(
        self, arguments: list[str], folder: Path, seconds: float
    ) -> subprocess.CompletedProcess[str]:
        """Run a command; see `subprocess.run`. Raises TimeoutExpired."""
        assert self._program.stdin is not None
        assert self._program.stdout is not None
        with tempfile.TemporaryDirectory() as given:
            outputs = [str(Path(given) / name) for name in ("out", "err")]
            order = {
                "arguments": arguments,
                "folder": str(folder),
                "outputs": outputs,
                "seconds": seconds,
            }
            self._program.stdin.write(json.dumps(order) + "\n")
            self._program.stdin.flush()
            code = json.loads(self._program.stdout.readline())
            out, err = (Path(path).read_text("utf-8") for path in outputs)
        if code is None:
            raise subprocess.TimeoutExpired(arguments, seconds, out, err)
        return subprocess.CompletedProcess(arguments, code, out, err)


def _lasting(environment: Mapping[str, str]) -> dict[str, str]:
    return {name: text for name, text in environment.items() if name not in SELDOM_THE_SAME}


def _serve() -> None:
    # What a module says while it is imported is no answer.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    for name in (MODULE, *OFTEN_NEEDED):
        importlib.import_module(name)
    # It is run anew as the main module, which must not be there yet.
    sys.modules.pop(MODULE)
    # A thread would not be there in a fork.
    assert threading.active_count() == 1, threading.enumerate()
    for line in sys.stdin:
        order = json.loads(line)
        child = os.fork()
        if child == 0:
            _be_the_command(order)
        print(json.dumps(_code_of(child, order["seconds"])), file=answers, flush=True)


def _be_the_command(order: dict[str, Any]) -> NoReturn:
    """Become a process that runs a command, and end with it."""
    nothing = os.open(os.devnull, os.O_RDONLY)
    out, err = (os.open(path, os.O_WRONLY | os.O_CREAT) for path in order["outputs"])
    for theirs, ours in ((nothing, 0), (out, 1), (err, 2)):
        os.dup2(theirs, ours)
        os.close(theirs)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    os.chdir(order["folder"])
    sys.path[0] = order["folder"]
    sys.argv = [MODULE, *order["arguments"]]
    code = 1
    try:
        runpy.run_module(MODULE, run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        # As Python does at its end; os._exit because the fork must not go on with the rest.
        threading._shutdown()  # type: ignore[attr-defined]
        atexit._run_exitfuncs()
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _code_of(child: int, seconds: float) -> int | None:
    """Return the exit status of a fork, negative for a signal; None if it was given up."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found, status = os.waitpid(child, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.005)
    os.kill(child, 9)
    os.waitpid(child, 0)
    return None


if __name__ == "__main__":
    _serve()
