"""Ctrl-C at moments when it would be lost."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from protocols import ROOT
from study.shell.interrupts import ctrl_c_later

WHILE_A_WINDOW_OPENS = """
import os, signal, threading, time
signal.signal(signal.SIGINT, signal.default_int_handler)
import pygame.pkgdata
from study.shell.window import Window

find = pygame.pkgdata.getResource

def interrupted(*words):
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.05)
    return find(*words)

pygame.pkgdata.getResource = interrupted
# Ctrl-C may reach any thread of the process.
threading.Thread(target=time.sleep, args=(60,), daemon=True).start()
try:
    Window((1280, 720))
except KeyboardInterrupt:
    print("told")
else:
    print("lost")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal as POSIX does")
def test_ctrl_c_while_a_window_opens_is_not_lost() -> None:
    """SDL's search for an icon discards what is raised in it."""
    done = subprocess.run(
        [sys.executable, "-c", WHILE_A_WINDOW_OPENS],
        cwd=ROOT,
        env={**os.environ, "SDL_VIDEODRIVER": "dummy"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.stdout.split()[-1:] == ["told"], done.stdout + done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal as POSIX does")
def test_it_comes_at_the_end_and_once() -> None:
    """Held back by the outermost of two; then whatever was there before acts on it."""
    over = threading.Event()
    other = threading.Thread(target=over.wait)
    other.start()
    came: list[str] = []
    before = signal.signal(signal.SIGINT, lambda *_: came.append("here"))
    try:
        with ctrl_c_later():
            with ctrl_c_later():
                os.kill(os.getpid(), signal.SIGINT)
                time.sleep(0.05)
                assert not came
            assert not came
        assert came == ["here"]
        signal.raise_signal(signal.SIGINT)
        assert came == ["here", "here"]
    finally:
        signal.signal(signal.SIGINT, before)
        over.set()
        other.join()
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, set())
