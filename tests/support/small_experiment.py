"""The shipped experiment made small: every part of it runs, in about a second a trial."""

from __future__ import annotations

import re
from pathlib import Path

SMALLER = {
    "trials = 250": "trials = 3",
    "horizon = 200": "horizon = 60",
    "starts = [0-9]+": "starts = 30",
    "held_out_starts = [0-9]+": "held_out_starts = 20",
    "hidden = \\[64, 64\\]": "hidden = [8, 8]",
    "epochs = [0-9]+": "epochs = 2",
    "runs = [0-9]+": "runs = 2",
    "timesteps = [0-9]+": "timesteps = 30",
    "episodes = 10": "episodes = 3",
    "episodes = 8": "episodes = 2",
    "dwells = .*": "dwells = [1, 5]",
    "trials = (30|6)\\n": "trials = 1\\n",
    "temperatures = .*": "temperatures = [1.0]",
    "runs = \\[.*": "runs = [1, 2]",
    "hidden = \\[16, 64, 128\\]": "hidden = [4]",
    "sizes = .*": "sizes = [4, 40]",
}


def small_experiment(folder: Path, **changes: str) -> Path:
    """Write the small experiment into a folder; each change is an exact text and its new one."""
    shipped = Path(__file__).resolve().parents[2] / "protocols" / "simulation.toml"
    text = shipped.read_text(encoding="utf-8")
    for old, new in SMALLER.items():
        text, count = re.subn(f"^{old}" if old[0] != "\\" else old, new, text, flags=re.MULTILINE)
        assert count, f"the shipped experiment has no {old}"
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / "small.toml"
    path.write_text(text, encoding="utf-8")
    return path
