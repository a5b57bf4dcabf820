"""Picture the console beside a real session, for the docs.

Needs Xvfb, chromium and the extra `console`. Runs the pilot protocol in a window on a virtual X
server; keys go through it up to phase three, where the console takes a note and is pictured:
docs/images/console.png.
"""

from __future__ import annotations

import asyncio
import os
import re
import subprocess
import sys
import tempfile
import threading
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from textual.pilot import Pilot  # noqa: E402
from textual.widgets import Input  # noqa: E402

from benchmarks.pressed_sessions import Played, Player, socket_of  # noqa: E402
from benchmarks.soak import stretched  # noqa: E402
from real_study import real_study  # noqa: E402
from study.console.app import ConsoleApp  # noqa: E402
from study.console.watching import WatchScreen  # noqa: E402
from x11_driver import Hands  # noqa: E402

SIZE = (112, 32)
PHASE, TIMESTEP = 3, 20
NOTE = "asked which key selects a robot; explained again"
TARGET = ROOT / "docs" / "images" / "console.png"


async def picture(pilot: Pilot[None], app: ConsoleApp, path: Path, drawing: Path) -> None:
    """Take a note in phase three, and picture the screen a little later."""

    def there() -> bool:
        status = app.screen.status if isinstance(app.screen, WatchScreen) else None
        trial = status.trial if status else None
        return bool(status and trial and status.place.phase == PHASE
                    and trial.timestep >= TIMESTEP)  # fmt: skip

    app.follow(path)
    while not there():
        await pilot.pause(0.2)
    await pilot.press("n")
    await pilot.pause(0.5)
    # Keys pressed one by one take as long as a trial.
    app.screen.query_one(Input).value = NOTE
    await pilot.press("enter")
    # The message that it is recorded goes away by itself.
    await pilot.pause(8.0)
    app.save_screenshot(str(drawing))
    await pilot.press("e")
    await pilot.pause(0.5)
    app.screen.query_one(Input).value = "pictured"
    await pilot.press("enter")
    await pilot.pause(1.0)


async def watch(path: Path, drawing: Path) -> None:
    """Run the console without a terminal."""
    app = ConsoleApp("nobody: the session is chosen")
    async with app.run_test(size=SIZE) as pilot:
        await picture(pilot, app, path, drawing)


def go_through(hands: Hands, found: Played, path: Path) -> None:
    """Press the session's keys; where that fails, say so past Textual, which takes what is said."""
    try:
        Player(hands, found, seed=1).play(path)
    except BaseException:
        traceback.print_exc(file=sys.__stderr__)
        raise


def as_png(drawing: Path, target: Path) -> None:
    """Let a browser draw an SVG in its own size."""
    found = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', drawing.read_text(encoding="utf-8"))
    if found is None:
        raise ValueError("Textual draws otherwise now")
    width, height = (int(float(side)) + 1 for side in found.groups())
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    command += [f"--window-size={width},{height}", f"--screenshot={target}", drawing.as_uri()]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)


def main() -> int:
    """Run the session and picture it."""
    with tempfile.TemporaryDirectory(prefix="sa") as place:
        os.environ |= {"XDG_RUNTIME_DIR": place, "TMPDIR": place}
        tempfile.tempdir = place
        protocol = stretched(Path(place), 7.5, "manual")
        found = Played("P01", Path(place) / "recordings")
        with real_study(str(protocol), found.folder) as (hands, _):
            hands.wait_for_window()
            path = socket_of("P01")
            player = threading.Thread(target=go_through, args=(hands, found, path), daemon=True)
            player.start()
            drawing = Path(place) / "console.svg"
            asyncio.run(watch(path, drawing))
            player.join(30)
        as_png(drawing, TARGET)
    print(f"Written: {TARGET}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
