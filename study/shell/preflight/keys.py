"""Check of the keyboard: keys arrive, and two are held at once."""

from __future__ import annotations

import time

from study.preflight_result import Check
from study.screens import KeyTrialScreen
from study.shell.raw_inputs import RawClose, RawKey
from study.shell.window import Window

PATIENCE_S = 10.0
FRAME_S = 1 / 60
NAME = "keyboard"


def keyboard(window: Window, keys: tuple[str, str], patience_s: float = PATIENCE_S) -> Check:
    """Ask for two keys at once; wait until they arrive or patience ends.

    Args:
        window: open.
        keys: two keys that participants hold together.
        patience_s: how long to wait.
    """
    wanted = f"{keys[0]} and {keys[1]} held down at once"
    until = time.perf_counter() + patience_s
    held: set[str] = set()
    seen: set[str] = set()
    while time.perf_counter() < until:
        window.show(KeyTrialScreen(tuple((key, key in seen) for key in keys), patience_s))
        window.draw(0)
        window.wait(FRAME_S)
        for raw in window.poll():
            if isinstance(raw, RawClose):
                until = 0.0
            if isinstance(raw, RawKey):
                (held.add if raw.down else held.discard)(raw.key)
                seen.add(raw.key)
            if set(keys) <= held:
                return Check(name=NAME, state="green", found="both arrived together", wanted=wanted)
    if set(keys) <= seen:
        found, advice = "both arrived, never together", "Use a keyboard that reports both at once."
    elif seen:
        found, advice = f"only {', '.join(sorted(seen))}", "Check the keyboard and its layout."
    else:
        found, advice = "no key arrived", "Click into the window; check the keyboard."
    return Check(name=NAME, state="red", found=found, wanted=wanted, advice=advice)
