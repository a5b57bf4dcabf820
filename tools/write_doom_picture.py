"""Picture twelve robots of a live session in DOOM, for the README and the docs.

Needs the extra "doom". A simulated participant goes through protocols/doom.toml, shortened, in a
window on the real clock: docs/images/doom.png is what it shows in the middle of a manual trial,
docs/images/doom_page.png the page that explains the task.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from contextlib import closing, suppress
from pathlib import Path

os.environ["SDL_VIDEODRIVER"] = "dummy"

import pygame
from PIL import Image

from study.commands.composing import session_opened, start_failover_recorder
from study.commands.recorded_scorers import recorded_weights
from study.commands.simulating import simulated_assignments
from study.errors import StudyError
from study.loading import load_protocol
from study.screens import FleetScreen, PageScreen, Screen
from study.session.session import Session
from study.shell.conductor import Conductor
from study.shell.fitting import InlineFitter
from study.shell.fleet import open_fleet
from study.shell.live_loop import LiveClock, LiveLoop
from study.shell.raw_inputs import RawInput, RawKey
from study.shell.window import Window
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import draw_parameters

ROOT = Path(__file__).resolve().parents[1]
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
QUICK = {"words_per_second": 1000.0, "page_minimum_s": 0.3, "answer_delay_s": 0.05}


class AllPicturedError(Exception):
    """The session need not go on."""


class PicturedWindow(Window):
    """A window at which a simulated participant sits, and which is pictured."""

    operator: SimulatedOperator
    clock: LiveClock
    missing: set[str]

    def poll(self) -> list[RawInput]:
        """Return what the participant presses at what is shown; close it when all is pictured."""
        super().poll()
        if not self.missing:
            raise AllPicturedError
        screen = self.screen
        if screen is None:
            return []
        now = time.perf_counter_ns()
        strokes = self.operator.act(screen, self.clock.now())
        return [RawKey(stroke.key, stroke.down, now, 0) for stroke in strokes]

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
        opened, clock = session_opened(loaded, assignment), LiveClock()
        task = loaded.protocol.task
        recorder = start_failover_recorder(Path(folder), loaded, opened)
        fleet = open_fleet(task.name, task.parameters)
        fitter = InlineFitter(loaded.description, recorded_weights(loaded))
        with closing(fleet), closing(fitter), closing(PicturedWindow(SIZE)) as window:
            window.operator = SimulatedOperator(
                draw_parameters(SEED, 0).model_copy(update=QUICK), SEED
            )
            window.clock, window.missing = clock, {"doom", "doom_page"}
            conductor = Conductor(
                Session(), recorder, fleet, fitter,
                epoch_ns=0, waits_for_disk=False, on_pictures=window.pictures.take,
            )  # fmt: skip
            conductor.feed(opened)
            with suppress(AllPicturedError):
                LiveLoop(conductor, window, recorder, clock).run()
            missing = window.missing
        recorder.close()
    return len(missing)


if __name__ == "__main__":
    sys.exit(main())
