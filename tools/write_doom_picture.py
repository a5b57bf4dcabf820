"""Picture twelve robots of a live session in DOOM, for the README and the docs.

Needs the extra "doom". A simulated participant goes through protocols/doom.toml, shortened, in a
window on the real clock: docs/images/doom.png is what it shows in the middle of a manual trial,
docs/images/doom_page.png the page that explains the task.
"""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import closing, suppress
from pathlib import Path

os.environ["SDL_VIDEODRIVER"] = "dummy"

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

import pygame  # noqa: E402
from PIL import Image  # noqa: E402

from operated_window import OperatedWindow, go_through  # noqa: E402
from study.commands.composing import session_opened, start_failover_recorder  # noqa: E402
from study.commands.simulating import simulated_assignments  # noqa: E402
from study.errors import StudyError  # noqa: E402
from study.loading import load_protocol  # noqa: E402
from study.screens import FleetScreen, PageScreen, Screen  # noqa: E402
from study.shell.raw_inputs import RawInput  # noqa: E402

IMAGES = ROOT / "docs" / "images"
SIZE, COLOURS = (1280, 960), 64
ROBOTS, TIMESTEP = 12, 110
SEED = 3
SHORTER = (
    ("episodes = 10", "episodes = 3"),
    ("timesteps = 260", "timesteps = 10"),
    ("trials = 6", "trials = 1"),
    ("trial_timesteps = 350", "trial_timesteps = 60"),
)


class AllPicturedError(Exception):
    """The session need not go on."""


class PicturedWindow(OperatedWindow):
    """A window at which a simulated participant sits, and which is pictured."""

    missing: set[str]

    def poll(self) -> list[RawInput]:
        """Return what the participant presses; close the window when all is pictured."""
        if not self.missing:
            raise AllPicturedError
        return super().poll()

    def present(self) -> None:
        """Present, and save what the docs show."""
        super().present()
        name = _name_of(self.screen)
        if name in self.missing:
            self.missing.remove(name)
            _save(self._surface, IMAGES / f"{name}.png")


def _name_of(screen: Screen | None) -> str:
    """Return the name of the picture that a screen is for; empty for none."""
    if isinstance(screen, PageScreen) and screen.figure == "map":
        return "doom_page"
    if not isinstance(screen, FleetScreen) or screen.robots != ROBOTS or screen.operated < 0:
        return ""
    landed = (screen.t_ns - screen.switched_ns) / 1e9 > screen.landing_seconds
    return "doom" if screen.timestep >= TIMESTEP and screen.view == "tiles" and landed else ""


def _save(surface: pygame.Surface, path: Path) -> None:
    """Write a picture in few colours."""
    pixels = pygame.image.tobytes(surface, "RGB")
    picture = Image.frombytes("RGB", surface.get_size(), pixels)
    # In one step the pale grounds of the screen would lose their colours to what is in the rooms.
    finer = picture.quantize(256, method=Image.Quantize.MEDIANCUT).convert("RGB")
    reduced = finer.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    reduced.save(path, optimize=True)
    print(path.relative_to(ROOT))


def main() -> int:
    """Run the session up to the pictures."""
    text = (ROOT / "protocols" / "doom.toml").read_text(encoding="utf-8")
    for old, new in SHORTER:
        if old not in text:
            raise StudyError(f"protocols/doom.toml has no {old!r}")
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "doom.toml"
        path.write_text(text, encoding="utf-8")
        loaded = load_protocol(str(path))
        assignment = next(
            each
            for each in simulated_assignments(loaded, 2, seed=SEED)
            if each.order[0] == "manual"
        )
        opened = session_opened(loaded, assignment)
        recorder = start_failover_recorder(Path(folder), loaded, opened)
        with closing(PicturedWindow(SIZE, SEED, page_minimum_s=0.3)) as window:
            window.missing = {"doom", "doom_page"}
            with suppress(AllPicturedError):
                go_through(window, loaded, opened, recorder)
            missing = window.missing
        recorder.close()
    return len(missing)


if __name__ == "__main__":
    sys.exit(main())
