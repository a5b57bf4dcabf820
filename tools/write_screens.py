"""Write docs/images anew: the screens of the pilot, those it lacks and a replay, in 128 colours.

Those of Gymnasium's environments need the extra "gymnasium".
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import pygame
from PIL import Image

from study.commands.picturing import MOMENT, Look, draw_gallery
from study.commands.simulating import simulate_study
from study.loading import load_protocol
from study.messages import SOURCE, messages_for
from study.recording.parts import read_whole_session
from study.screens import FleetScreen
from study.shell.replay.marks import read_marks
from study.shell.replay.picture import Picture, size_for
from study.shell.replay.strip import Shown
from study.shell.replay.tape import Tape

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
PROTOCOLS = ROOT / "protocols"
LOOK = Look((1280, 960), 1.0, messages_for(SOURCE))
COLOURS = 128
LATER_NS = 1_500_000_000
"""After a takeover: its landing is over."""
PILOT = {
    "page_welcome": "welcome",
    "page_bring_the_robots_to_their_goal": "how_it_works",
    "page_first__a_short_drive": "practice_page",
    "fleet_manual_tiles_1": "practice",
    "page_teach_one_robot": "phase_one_page",
    "fleet_correction_tiles_1": "phase_one",
    "page_look_after_4_robots": "phase_two_page",
    "fleet_manual_tiles_4": "phase_two",
    "page_12_robots__you_choose": "manual_page",
    "fleet_manual_tiles_12": "manual",
    "page_12_robots__you_are_switched": "assisted_page",
    "fleet_assisted_operated_only_12": "assisted",
    "survey_about_the_block_you_just_finished": "survey",
    "survey_about_the_block_you_just_finished_after_reveal": "survey_after_reveal",
    "reveal_part_3_of_4__block_1_of_2__finished": "reveal",
    "end_thank_you": "thanks",
    "pause": "pause",
    "ready_trial": "ready_trial",
    "ready_episode": "ready_episode",
    "wait_fit": "wait_fit",
    "wait_phase_four": "wait_phase_four",
}
"""The gallery's name of a screen to the docs' name; the second block's reveal is left out."""
OTHERS = {
    "consent_before_we_start": "consent",
    "survey_about_you": "about_you",
    "survey_is_everything_clear": "comprehension",
    "countdown": "countdown",
    "break": "break",
    "page_12_robots__you_choose__with_a_suggestion": "suggested_page",
    "fleet_suggested_enlarged_12": "suggested_enlarged",
    "fleet_assisted_tiles_12": "assisted_tiles",
    "survey_how_was_it_to_do_this": "load_index",
    "survey_in_your_own_words": "remarks",
    "page_what_this_was_about": "debrief",
    "pause_confirm_erase": "pause_erase",
    "pause_held": "pause_held",
}
"""The same for the protocol that has every screen."""
CARTS = {"fleet_manual_tiles_6": "cart_pole", "fleet_assisted_operated_only_6": "cart_pole_large"}
ICE = {"fleet_manual_tiles_6": "frozen_lake", "page_what_is_to_be_done": "frozen_lake_page"}
ALL = {"pilot": PILOT, "every_screen": OTHERS, "cart_pole": CARTS, "frozen_lake": ICE}
"""By protocol."""


def main() -> int:
    """Draw and reduce; fail if a screen of the docs was not drawn."""
    for protocol, names in ALL.items():
        with tempfile.TemporaryDirectory() as folder:
            pictures = draw_gallery(load_protocol(protocol), Path(folder), [LOOK])
            drawn = {path.stem.partition("_")[2]: path for path in pictures}
            missing = sorted(set(names) - set(drawn))
            if missing:
                print(f"No longer drawn: {', '.join(missing)}; drawn: {', '.join(drawn)}")
                return 1
            for name, target in names.items():
                save_reduced(drawn[name], target)
    with tempfile.TemporaryDirectory() as folder:
        save_reduced(draw_replay(Path(folder)), "replay")
    print(f"{sum(map(len, ALL.values())) + 1} pictures in {IMAGES}")
    return 0


def save_reduced(drawn: Path, target: str) -> None:
    """Save a picture under its name in the docs."""
    with Image.open(drawn) as picture:
        reduced = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        reduced.save(IMAGES / f"{target}.png", optimize=True)


def draw_replay(folder: Path) -> Path:
    """Draw the analyst's view of a simulated pilot in which all robots are seen while switched."""
    protocol = folder / "pilot.toml"
    text = (PROTOCOLS / "pilot.toml").read_text(encoding="utf-8")
    protocol.write_text(text.replace('view = "operated_only"', 'view = "tiles"'))
    (made,) = simulate_study(str(protocol), 1, 1, folder, jobs=1)
    recording = read_whole_session(made.path)
    marks, tape = read_marks(recording), Tape(recording)
    for takeover in marks.takeovers:
        t_ns = takeover.t_ns + LATER_NS
        head = tape.go_to(t_ns)
        screen = head.screen
        if not isinstance(screen, FleetScreen) or takeover.by != "scorer":
            continue
        if screen.timestep > MOMENT and len(screen.tiles) == 12:
            break
    else:
        raise SystemExit("No scorer switches between twelve tiles in this protocol any more.")
    pygame.font.init()
    picture = Picture(size_for("analyst", marks), marks, "analyst", LOOK.messages)
    surface = pygame.Surface(picture.size)
    picture.draw(surface, Shown(head, t_ns, playing=True, speed=1.0))
    drawn = folder / "replay.png"
    pygame.image.save(surface, str(drawn))
    return drawn


if __name__ == "__main__":
    sys.exit(main())
