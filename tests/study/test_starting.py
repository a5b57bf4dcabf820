"""Ctrl-C of a command line is one line and exit status 130, whenever it comes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from patience import PATIENCE_S

WHEN = {
    "imported": "signal.raise_signal(signal.SIGINT)",
    "imported, where no exception gets through": "lose_it()",
    "running": "def main():\n    with stopped_in_a_line():\n        raise KeyboardInterrupt",
    "running, where no exception gets through": (
        "def main():\n    with stopped_in_a_line():\n        lose_it()\n        time.sleep(600)"
    ),
    "by Typer": "def main():\n    with stopped_in_a_line():\n        raise SystemExit(130)",
}
BEGUN = """
import signal, time, weakref
from study.starting import stopped_in_a_line

class Thing: ...

def lose_it():
    thing = Thing()
    there = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))
    del thing

"""


def told(code: str, folder: Path, before: str = "") -> tuple[int, str, str]:
    """Start a command line of this code; return its exit status, and what it said."""
    (folder / "a_command_line.py").write_text(f"{BEGUN}\n{code}\n")
    program = (
        # As a program is started where Ctrl-C is not ignored.
        "import signal, sys\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"sys.path.insert(0, {str(folder)!r})\n{before}\n"
        "from study.starting import start\n"
        "start('a_command_line')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("when", WHEN)
def test_it_is_said_once(tmp_path: Path, when: str) -> None:
    """While all is imported, while it runs, and where Typer has made an exit of it."""
    assert told(WHEN[when], tmp_path) == (130, "", "Stopped.\n")


def test_another_exit_is_none_of_it(tmp_path: Path) -> None:
    """What a command ends with stays as it is."""
    code = "def main():\n    with stopped_in_a_line():\n        raise SystemExit(2)"
    assert told(code, tmp_path) == (2, "", "")


def test_who_has_it_ignored_is_not_stopped(tmp_path: Path) -> None:
    """As under nohup: neither while all is imported nor later."""
    code = (
        "signal.raise_signal(signal.SIGINT)\n"
        "def main():\n    with stopped_in_a_line():\n        signal.raise_signal(signal.SIGINT)\n"
        "        print('done')"
    )
    ignored = "signal.signal(signal.SIGINT, signal.SIG_IGN)"
    assert told(code, tmp_path, ignored) == (0, "done\n", "")


def test_another_exception_that_is_lost_is_told(tmp_path: Path) -> None:
    """What goes wrong in a callback is no secret."""
    code = (
        "def main():\n    thing = Thing()\n"
        "    there = weakref.ref(thing, lambda _: 1 / 0)\n    del thing"
    )
    status, _, said = told(code, tmp_path)
    assert status == 0
    assert "ZeroDivisionError" in said
